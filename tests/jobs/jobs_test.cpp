// Each job ends once, whatever faults the daemon, keepers, messages, clocks and disk have.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/jobs/service.h"
#include "tests/support/property.h"

namespace sleight::jobs::simulated {
namespace {

std::uint64_t seeds() {
  return property::long_run() ? 10'000 : property::of_tier(20, 150);
}

/// The seeds are divided among this many tests, so that several processes can run them.
constexpr std::uint64_t k_shares = 4;

struct Summary {
  std::uint64_t runs = 0;
  std::uint64_t jobs = 0;
  std::uint64_t large = 0;
  std::uint64_t faults = 0;
  Outcome sum{};
  double last_s = 0;

  void add(const Scenario& scenario, const Outcome& outcome) {
    ++runs;
    jobs += scenario.jobs.size();
    large += scenario.jobs.size() >= 500 ? 1 : 0;
    faults += scenario.faults.size();
    sum.daemons += outcome.daemons;
    sum.inputs += outcome.inputs;
    sum.launches += outcome.launches;
    sum.announcements += outcome.announcements;
    last_s = std::max(last_s, outcome.end_s - scenario.quiet_s);
  }
  void print() const {
    fmt::print(
        "{} seeds ({} of 500 jobs or more), {} jobs, {} faults, {} daemons, {} inputs, {} "
        "launches, "
        "{} deletions announced; at most {:.0f} s from the last fault to the end\n",
        runs, large, jobs, faults, sum.daemons, sum.inputs, sum.launches, sum.announcements,
        last_s);
  }
};

void check_seed(std::uint64_t seed, const ScenarioChoice& choice, Summary& summary) {
  const Scenario scenario = scenario_of(seed, choice);
  SCOPED_TRACE(scenario.name());
  const Outcome outcome = Service(scenario).run(liveness_bound_s(scenario));
  EXPECT_EQ(outcome.violation, "");
  EXPECT_TRUE(outcome.is_finished) << outcome.unfinished << ", " << outcome.end_s - scenario.quiet_s
                                   << " s after the last fault";
  summary.add(scenario, outcome);
}

class Seeds : public testing::TestWithParam<std::uint64_t> {
 protected:
  void check_share(const ScenarioChoice& choice, std::uint64_t last) const {
    Summary summary;
    for (const std::uint64_t seed : property::seeds(last)) {
      if ((seed - 1) % k_shares != GetParam()) continue;
      check_seed(seed, choice, summary);
      if (HasFailure()) break;
    }
    summary.print();
  }
};

TEST_P(Seeds, EachJobEndsOnce) {
  // Goal: each job ends exactly once, and the other invariants of jobs.h hold, whatever faults
  // occur. Method: simulate services that have 1 to 1,000 jobs and up to 20 users. The daemon, the
  // keepers, messages, the clock and the disk fail in every way. Check the service's rules with a
  // ledger, and limit the time from the last fault to the end of all jobs.
  check_share({}, seeds());
}

TEST_P(Seeds, FewJobsToo) {
  // Goal: the invariants of jobs.h hold even if faults hit every step of a job. Method: simulate
  // services that have at most ten jobs. Use ten times as many seeds as for large services.
  check_share({.jobs_max = 10}, 10 * seeds());
}

INSTANTIATE_TEST_SUITE_P(Services, Seeds, testing::Range<std::uint64_t>(0, k_shares));

}  // namespace
}  // namespace sleight::jobs::simulated
