#include "common/failure_file/failure_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/support/facts.h"
#include "tests/support/property.h"

namespace sleight::failure_file {
namespace {

using ::testing::HasSubstr;

constexpr const char* k_request = "[world]\nname = \"ball_2d\"\n[stop]\nscans = 3\n";

FailureFile example() {
  return {.program_version = "0.1.0+gabc",
          .request_text = k_request,
          .replica = {base::ChainId{3}, base::ReplicaId{4'000'000'000}},
          .failed = {.scan = base::ScanIndex{(std::uint64_t{1} << 62U) + 1},
                     .failure = {.kind = plan::FailureKind::impact_unresolved,
                                 .message = "die \"1\": \\ a [world] of\nlines at 0.5 s",
                                 .state = {std::byte{0}, std::byte{255}, std::byte{16}}}}};
}

TEST(FailureFile, ComesBack) {
  // Goal: a failure file reads back equal. Method: write every kind of failure. Each failure has
  // large numbers, and a message that contains quotes, brackets and line ends.
  for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind) {
    FailureFile file = example();
    file.failed.failure.kind = static_cast<plan::FailureKind>(kind);
    file.failed.failure.state.resize(kind * 1000, std::byte{0xa5});
    const auto back = read(to_text(file), "x.toml");
    ASSERT_TRUE(back.ok()) << request::to_string(back.error());
    EXPECT_EQ(back.value().failed, file.failed);
    EXPECT_EQ(back.value().replica, file.replica);
    EXPECT_EQ(back.value().program_version, file.program_version);
    // The request's text keeps the file's line numbers, so that errors name the right lines.
    const std::string& text = back.value().request_text;
    EXPECT_EQ(text.substr(text.find('[')), k_request);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), std::ranges::count(to_text(file), '\n'));
  }
}

TEST(FailureFile, NamesWhatIsWrong) {
  // Goal: the error about a faulty file names the file, the line and the key.
  const std::string good = to_text(example());
  const auto error_of = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const auto back = read(text, "x.toml");
    return back.ok() ? "read" : request::to_string(back.error());
  };
  EXPECT_THAT(error_of("[failure]", "[success]"), HasSubstr("x.toml:1:1: not a failure file"));
  EXPECT_THAT(error_of("\n[world]", "\n[word]"), HasSubstr("section [world] is missing"));
  EXPECT_THAT(error_of("scan = 4", "scan = -4"),
              HasSubstr("x.toml:8:8: 'scan' must be an integer"));
  EXPECT_THAT(error_of("chain = 3", "chain = 4294967296"), HasSubstr("'chain' must be"));
  EXPECT_THAT(error_of("chain = 3\n", ""), HasSubstr("[failure] has no key 'chain'"));
  EXPECT_THAT(error_of("impact", "impart"), HasSubstr("'kind' must be one of search_gave_up"));
  EXPECT_THAT(error_of("00ff10", "00ff1"), HasSubstr("'state' must be hexadecimal"));
  EXPECT_THAT(error_of("00ff10", "00FF10"), HasSubstr("'state' must be hexadecimal"));
  EXPECT_THAT(error_of("message = \"", "message = 4 #\""), HasSubstr("x.toml:5:11: 'message'"));
}

TEST(FailureFile, ChangedFilesAreRefused) {
  // Goal: a file that was changed is refused, unless it has no checksum. Method: change each byte
  // of a file, then remove the checksum and change the file again.
  const std::string good = to_text(example());
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string text = good;
    text[at] = text[at] == 'e' ? 'f' : 'e';
    const auto back = read(text, "x.toml");
    // If the key `checksum` was renamed, the file has no checksum and is accepted.
    const std::size_t key = good.find("checksum");
    if (at >= key && at <= key + std::string_view("checksum").size()) continue;
    EXPECT_FALSE(back.ok()) << text;
  }
  std::string without = good;
  const std::size_t line = good.find("checksum");
  without.erase(line, good.find('\n', line) + 1 - line);
  EXPECT_TRUE(read(without, "x.toml").ok());
  without.replace(without.find("00ff10"), 6, "00ff11");
  EXPECT_TRUE(read(without, "x.toml").ok());
  std::string changed = good;
  changed.replace(changed.find("00ff10"), 6, "00ff11");
  EXPECT_THAT(request::to_string(read(changed, "x.toml").error()),
              tests::HasFacts("x.toml:10:12: |changed"));
}

TEST(FailureFile, AnyBytesAreReadOrRefused) {
  // Goal: the reader of failure files never crashes. Method: change, remove and copy random bytes
  // of a file. The file has no checksum, so that the other checks run.
  std::string good = to_text(example());
  const std::size_t line = good.find("checksum");
  good.erase(line, good.find('\n', line) + 1 - line);
  const std::uint64_t inputs = property::of_tier(2'000, 20'000);
  std::uint64_t read_well = 0;
  for (const std::uint64_t input : property::cases(inputs)) {
    random::Stream stream({.seed = 11, .purpose = random::Purpose::prior}, input);
    const auto below = [&](std::uint64_t count) {
      return static_cast<std::size_t>(random::UniformInteger{.count = count}.draw(stream));
    };
    std::string text = good;
    for (std::size_t changes = 1 + below(3); changes > 0 && !text.empty(); --changes) {
      const std::size_t at = below(text.size());
      switch (below(3)) {
        case 0:
          text[at] = static_cast<char>(below(256));
          break;
        case 1:
          text.erase(at, 1 + below(20));
          break;
        default:
          text.insert(at, text.substr(below(text.size()), 1 + below(20)));
      }
    }
    const auto back = read(text, "x.toml");
    read_well += back.ok() ? 1U : 0U;
    ASSERT_TRUE(back.ok() || !back.error().message.empty());
  }
  if (!property::all_cases()) return;
  EXPECT_GT(read_well, inputs / 200);
  EXPECT_LT(read_well, inputs / 20 * 19);
}

TEST(FailureFile, IsNamedByWhereItHappened) {
  // Goal: a failure file is named after the failure's chain, replica, scan and number within the
  // scan.
  const plan::ReplicaKey replica{base::ChainId{2}, base::ReplicaId{5}};
  EXPECT_EQ(name_of(replica, base::ScanIndex{77}, 0), "failure-2-5-77.toml");
  EXPECT_EQ(name_of(replica, base::ScanIndex{77}, 1), "failure-2-5-77-1.toml");
}

}  // namespace
}  // namespace sleight::failure_file
