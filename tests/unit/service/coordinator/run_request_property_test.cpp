#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string>
#include <utility>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/support/property.h"
#include "tests/unit/service/coordinator/ball_runs.h"

namespace sleight::coordinator {
namespace {

constexpr std::uint64_t k_seed = 141421;
#ifdef SLEIGHT_SANITIZED
const std::uint64_t k_runs = 2;
constexpr std::uint64_t k_questions = 48;  ///< maximum stop checks of a session
#else
const std::uint64_t k_runs = property::of_tier(2, 20);
constexpr std::uint64_t k_questions = 12;
#endif

class RunRequestProperty : public testing::BallRuns {};

TEST_F(RunRequestProperty, ThreadsAndStopsChangeNothing) {
  // Goal: an archive's bytes depend only on the request (C1), not on threads or on the moments when
  // sessions stop. Method: run each request in sessions of 1, 2 or 5 threads. Stop sessions at
  // random. Compare the archive with an uninterrupted run's archive. Requests end after scans,
  // rounds or independent solutions. Some requests have ladders. A ladder's blocks contain several
  // replicas.
  std::uint64_t sessions = 0;
  struct Case {
    std::string stop;
    std::string sampler = k_slow;
    std::string method = "metropolis_hastings";
  };
  const std::vector<Case> cases{
      {"scans = 400"},
      {"rounds = 5"},
      {"independent_solutions = 3\nscans = 1000"},
      {"scans = 60", "iterations_per_scan = 20\nanneal_scans = 10\n", "parallel_tempering"}};
  for (const auto& [stop, sampler, method] : cases) {
    const std::string request = request_text(stop, sampler, method);
    const std::string straight = path("straight.h5");
    const RunSummary expected = session(request, {.output = straight, .fresh = true});
    for (const std::uint64_t run : property::cases(k_runs / 3 + 1)) {
      SCOPED_TRACE(fmt::format("{}{}", sampler, stop));
      random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, run);
      const auto below = [&](std::uint64_t count) {
        return random::UniformInteger{.count = count}.draw(stream);
      };
      const std::string output = path("run.h5");
      RunSummary summary{.end = DriveEnd::stop_requested};
      for (bool fresh = true; summary.end != DriveEnd::finished; fresh = false) {
        constexpr std::array<std::uint32_t, 3> k_threads{1, 2, 5};
        ++sessions;
        summary = session(request,
                          {.output = output,
                           .fresh = fresh,
                           .stop_requested = stop_before_writing(1 + below(k_questions), summary)},
                          k_threads[below(3)]);
      }
      ASSERT_EQ(summary.scans, expected.scans);
      ASSERT_EQ(summary.digest, expected.digest);
      ASSERT_EQ(bytes_of(output), bytes_of(straight));
    }
  }
  if (!property::all_cases()) return;
  // Control: sessions were stopped early.
  EXPECT_GT(sessions, 2 * k_runs);
}

}  // namespace
}  // namespace sleight::coordinator
