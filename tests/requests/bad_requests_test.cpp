// Goal: for each bad request, the request reader reports exactly the expected errors at their
// places. For shipped requests, the reader reports no errors. Method: read each bad/<name>.toml as
// a ball_2d request, and compare its errors with the lines of bad/<name>.expected.
//
// If a wording changes, SLEIGHT_ACCEPT_ERRORS=1 rewrites the .expected files. Review such changes
// with git diff.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "worker/worlds/ball_2d/request.h"
#include "worker/worlds/dice/request.h"
#include "worker/worlds/spelling/request.h"
#include "worker/worlds/user_scene/request.h"

namespace sleight {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::vector<fs::path> files_with(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Returns the errors as the command line prints them. Empty for a good request.
std::string errors_of(const fs::path& request_file) {
  const std::vector<request::WorldBinding> known{worlds::ball_2d::request_binding()};
  const auto request =
      request::read_request(contents(request_file), request_file.filename().string(), known);
  std::string lines;
  if (!request) {
    for (const auto& diagnostic : request.error())
      lines += to_string(diagnostic) + '\n';
  }
  return lines;
}

/// Returns what is wrong with one request of the corpus, or nothing if its errors are as expected.
std::optional<std::string> complaint_about(const fs::path& request_file) {
  const std::string errors = errors_of(request_file);
  if (errors.empty()) return "it was read without errors";
  const fs::path expected_file = fs::path(request_file).replace_extension(".expected");
  if (!fs::exists(expected_file)) return "it has no .expected file; its errors are:\n" + errors;
  const std::string expected = contents(expected_file);
  if (errors != expected) return "expected:\n" + expected + "found:\n" + errors;
  return std::nullopt;
}

class BadRequest : public testing::TestWithParam<fs::path> {};

TEST_P(BadRequest, GetsItsErrors) {
  if (std::getenv("SLEIGHT_ACCEPT_ERRORS") != nullptr) {
    write(fs::path(GetParam()).replace_extension(".expected"), errors_of(GetParam()));
  }
  const auto complaint = complaint_about(GetParam());
  EXPECT_FALSE(complaint.has_value()) << GetParam() << ": " << *complaint;
}

INSTANTIATE_TEST_SUITE_P(Corpus, BadRequest,
                         testing::ValuesIn(files_with(SLEIGHT_BAD_REQUESTS, ".toml")),
                         [](const auto& entry) { return entry.param.stem().string(); });

TEST(Corpus, HasEnoughRequestsAndNoStrayExpectations) {
  EXPECT_GE(files_with(SLEIGHT_BAD_REQUESTS, ".toml").size(), 50U);
  for (const fs::path& expected : files_with(SLEIGHT_BAD_REQUESTS, ".expected")) {
    EXPECT_TRUE(fs::exists(fs::path(expected).replace_extension(".toml"))) << expected;
  }
}

// The check must fail if the expected errors are missing or differ from the actual errors. The
// check must also fail if the request has no error.
TEST(Corpus, CheckFailsWhereItShould) {
  const fs::path folder = fs::path(testing::TempDir()) / "sleight_bad_requests";
  fs::create_directories(folder);
  const fs::path bad = folder / "bad.toml";
  const fs::path expected = folder / "bad.expected";

  fs::remove(expected);
  write(bad, "[world]\nname = \"ball_2d\"\nlamda = 1\n[stop]\nscans = 1\n");
  EXPECT_THAT(complaint_about(bad).value_or(""), testing::HasSubstr("no .expected file"));
  write(expected, "bad.toml:3:2: unknown key\n");
  EXPECT_THAT(complaint_about(bad).value_or(""), testing::HasSubstr("found:\nbad.toml:3:1: "));
  write(expected, errors_of(bad));
  EXPECT_EQ(complaint_about(bad), std::nullopt);

  write(bad, "[world]\nname = \"ball_2d\"\n[stop]\nscans = 1\n");
  EXPECT_THAT(complaint_about(bad).value_or(""), testing::HasSubstr("without errors"));
  fs::remove_all(folder);
}

TEST(ShippedRequests, AreReadWithoutErrors) {
  const auto files = files_with(SLEIGHT_REQUESTS, ".toml");
  EXPECT_FALSE(files.empty());
  const std::vector<request::WorldBinding> known{
      worlds::ball_2d::request_binding(), worlds::dice::request_binding(),
      worlds::spelling::request_binding(), worlds::user_scene::request_binding()};
  for (const fs::path& file : files) {
    const auto request = request::read_request(contents(file), file.filename().string(), known);
    EXPECT_TRUE(request) << file << ": " << (request ? "" : to_string(request.error().front()));
  }
}

// requests/hi.toml states the defaults explicitly, except for the chain's sampler.
TEST(ShippedRequests, HiSpellsOutTheDefaults) {
  const std::vector<request::WorldBinding> known{worlds::spelling::request_binding()};
  const auto request =
      request::read_request(contents(fs::path(SLEIGHT_REQUESTS) / "hi.toml"), "hi.toml", known);
  ASSERT_TRUE(request) << to_string(request.error().front());
  EXPECT_EQ(request::parameters_of<worlds::spelling::Parameters>(request.value()).pattern,
            worlds::spelling::hi());
  const std::string full = normalised_text(request.value());
  const auto bare = request::read_request(
      "[world]\nname = \"spelling\"\n[sampler]\nmethod = \"metropolis_hastings\"\nchains = "
      "1\niterations_per_scan = 10\n"
      "[stop]\nscans = 2001\n[output]\nthin = 10\nkeep_per_lineage = 20\n",
      "bare.toml", known);
  ASSERT_TRUE(bare);
  const std::uint64_t seed = request.value().sampler.seed;
  const std::string plain = normalised_text(with_seed(bare.value(), seed));
  EXPECT_NE(full.find("bin_mm"), std::string::npos);
  EXPECT_EQ(plain.substr(plain.find("bin_mm")), full.substr(full.find("bin_mm")));
}

// requests/ball_2d.toml states the thesis's numbers. The numbers equal the defaults bit for bit.
TEST(ShippedRequests, Ball2dSpellsOutTheDefaults) {
  const std::vector<request::WorldBinding> known{worlds::ball_2d::request_binding()};
  const auto request = request::read_request(contents(fs::path(SLEIGHT_REQUESTS) / "ball_2d.toml"),
                                             "ball_2d.toml", known);
  ASSERT_TRUE(request);
  const auto bare = request::read_request(
      "[world]\nname = \"ball_2d\"\n[sampler]\nmethod = \"metropolis_hastings\"\n"
      "[stop]\nscans = 1000\n",
      "bare.toml", known);
  ASSERT_TRUE(bare);
  // All values are defaults except the thesis's method and the request's seed.
  const std::uint64_t seed = request.value().sampler.seed;
  EXPECT_EQ(normalised_text(with_seed(bare.value(), seed)), normalised_text(request.value()));
}

}  // namespace
}  // namespace sleight
