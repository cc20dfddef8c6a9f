// Goal: no file, however hostile, makes the request reader crash, hang or report nonsense. Method:
// read every input of libFuzzer as a request of every world. If a request is valid, reading its
// normalised text must give the same parameters and the same normalised text. A text with another
// stop rule must be readable too. An invalid request must have sorted errors. Each error must have
// a place within the file, and must be one line without control characters.
//
// CMakeLists.txt beside this file explains how to replay a failure.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/check.h"
#include "common/request/text.h"
#include "tests/fuzz/same_parameters.h"
#include "tests/unit/common/request/toy_world.h"
#include "worker/worlds/ball_2d/request.h"
#include "worker/worlds/dice/request.h"
#include "worker/worlds/spelling/request.h"
#include "worker/worlds/user_scene/request.h"

namespace sleight {
namespace {

struct Reading {
  std::vector<request::DirectionRequest> request;  ///< one, or none
  std::vector<request::Diagnostic> errors;
};

Reading read(std::string_view text) {
  Reading reading;
  const std::array worlds{worlds::ball_2d::request_binding(), worlds::spelling::request_binding(),
                          worlds::dice::request_binding(), worlds::user_scene::request_binding(),
                          request::toy::binding()};
  auto request = request::read_request(text, "fuzz.toml", worlds);
  if (request) {
    reading.request.push_back(std::move(request).value());
  } else {
    reading.errors = request.error();
  }
  return reading;
}

void check_parameters(const request::DirectionRequest& again,
                      const request::DirectionRequest& given) {
  const auto are_same = [&]<class Parameters>(std::string_view world) {
    if (given.world != world) return;
    CHECK(
        same(request::parameters_of<Parameters>(again), request::parameters_of<Parameters>(given)));
  };
  are_same.operator()<worlds::ball_2d::Parameters>("ball_2d");
  are_same.operator()<worlds::spelling::Parameters>("spelling");
  are_same.operator()<worlds::dice::Parameters>("dice");
  if (given.world == "scene") {
    using worlds::user_scene::Parameters;
    const auto& first = request::parameters_of<Parameters>(given);
    const auto& second = request::parameters_of<Parameters>(again);
    CHECK(first.built != nullptr && second.built != nullptr);
    CHECK_EQ(first.built->objects.size(), second.built->objects.size());
    CHECK_EQ(first.constraints.size(), second.constraints.size());
    const worlds::user_scene::Quantities one(first.scene, *first.built, first.uncertain);
    const worlds::user_scene::Quantities two(second.scene, *second.built, second.uncertain);
    CHECK_EQ(one.size(), two.size());
    const worlds::user_scene::Numbers state(one.size(), 0.25);
    CHECK(one.values(state) == two.values(state));
    CHECK_EQ(one.scene(state).has_value(), two.scene(state).has_value());
  }
  if (given.world == "toy") {
    CHECK(request::parameters_of<request::toy::Parameters>(again) ==
          request::parameters_of<request::toy::Parameters>(given));
  }
}

void check_round_trip(const Reading& given) {
  const request::DirectionRequest& request = given.request.front();
  const std::string normal = normalised_text(request);
  const Reading again = read(normal);
  CHECK_EQ(again.request.size(), 1U);
  CHECK(again.request.front() == request);
  CHECK_EQ(normalised_text(again.request.front()), normal);
  check_parameters(again.request.front(), request);

  const bool searches = request.sampler.method == request::Method::search;
  const bool relaxes = request.sampler.relax_scans.has_value();
  const request::Cut cut{.scans = searches ? 0U : 1000U,
                         .found = searches ? 7U : 0U,
                         .relaxed = relaxes ? 3U : 0U,
                         .prior_draws = 40};
  const std::string stopped = normalised_text_of(request, cut);
  const Reading stopped_again = read(stopped);
  CHECK_EQ(stopped_again.request.size(), 1U);
  CHECK_EQ(normalised_text(stopped_again.request.front()), stopped);
  CHECK_EQ(identity_text(stopped_again.request.front()), identity_text(request));
}

void check_errors(std::string_view text, const std::vector<request::Diagnostic>& errors) {
  CHECK(!errors.empty());
  CHECK_LE(errors.size(), request::k_diagnostics_max + 1);
  request::Place last;
  for (const request::Diagnostic& error : errors) {
    // Errors are ordered by place. Each place is in the file or just after the end of a line.
    CHECK(last <= error.place);
    last = error.place;
    const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
    CHECK_LE(error.place.line, lines);
    std::size_t begin = 0;
    for (std::uint32_t line = 1; line < error.place.line; ++line)
      begin = text.find('\n', begin) + 1;
    const std::size_t length = std::min(text.find('\n', begin), text.size()) - begin;
    CHECK_GE(error.place.column, 1U);
    CHECK_LE(error.place.column, length + 1);

    const std::string line = to_string(error);
    CHECK_EQ(request::printable(line, line.size()), line);
  }
}

}  // namespace
}  // namespace sleight

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const sleight::Reading reading = sleight::read(text);
  if (reading.request.empty()) {
    sleight::check_errors(text, reading.errors);
  } else {
    sleight::check_round_trip(reading);
  }
  return 0;
}
