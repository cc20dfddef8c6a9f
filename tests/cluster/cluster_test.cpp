// Tests of contracts C1 and C2 under faults.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/cluster/cluster.h"
#include "tests/support/property.h"

namespace sleight::cluster {
namespace {

/// Number of seeds in an ordinary run, or in a long one (SLEIGHT_SOAK=1).
std::uint64_t seeds() {
  return property::long_run() ? 10'000 : property::of_tier(20, 150);
}

/// Number of tests that share the seeds. Several processes can run the tests.
constexpr std::uint64_t k_shares = 4;

struct Summary {
  std::uint64_t runs = 0;
  std::uint64_t large = 0;
  std::uint64_t faults = 0;
  std::uint64_t sessions = 0;
  core::Counts counts{};
  double utilisation = 0;
  double last_s = 0;  ///< longest time from the last fault to the end

  void add(const Case& of, const Outcome& outcome) {
    ++runs;
    large += of.scenario.workers > 1024 ? 1 : 0;
    faults += of.scenario.faults.size();
    sessions += outcome.sessions;
    counts.blocks += outcome.counts.blocks;
    counts.copies += outcome.counts.copies;
    counts.refused += outcome.counts.refused;
    counts.states_missing += outcome.counts.states_missing;
    utilisation += outcome.utilisation;
    last_s = std::max(last_s, outcome.end_s - outcome.quiet_s);
  }
  void print() const {
    fmt::print(
        "{} seeds ({} above 1024 workers), {} faults, {} sessions, {} blocks, {} copies, {} "
        "refused, "
        "{} states missing; mean utilisation {:.2f}; at most {:.2f} s from the last fault to the "
        "end\n",
        runs, large, faults, sessions, counts.blocks, counts.copies, counts.refused,
        counts.states_missing, utilisation / static_cast<double>(runs), last_s);
  }
};

void check_seed(std::uint64_t seed, const CaseChoice& choice, Summary& summary) {
  const Case of = case_of(seed, choice);
  SCOPED_TRACE(of.name());
  const Outcome outcome = Cluster(of).run(liveness_bound_s(of));
  EXPECT_GE(of.expected.scans(), k_units_per_worker * of.scenario.workers);
  EXPECT_TRUE(outcome.is_finished)
      << "has not ended " << outcome.end_s - outcome.quiet_s << " s after the last fault";
  EXPECT_EQ(outcome.violation, "");
  EXPECT_EQ(outcome.difference, "");
  EXPECT_EQ(outcome.digest, digest_of(of.expected));
  summary.add(of, outcome);
}

class Seeds : public testing::TestWithParam<std::uint64_t> {
 protected:
  void check_share(const CaseChoice& choice, std::uint64_t last) const {
    Summary summary;
    for (const std::uint64_t seed : property::seeds(last)) {
      if ((seed - 1) % k_shares != GetParam()) continue;
      check_seed(seed, choice, summary);
      if (HasFailure()) break;
    }
    summary.print();
  }
};

TEST_P(Seeds, DigestIsTheSerialRuns) {
  // Goal: a run ends, has the same bits as a serial run, and loses no commit, whatever faults
  // workers, messages, coordinator and disk have. Method: simulate clusters of 1 to 4096 workers.
  // Compare digests with the serial run, check the store's invariants, and limit the time from the
  // last fault to the end.
  check_share({}, seeds());
}

TEST_P(Seeds, FewWorkersDoIt) {
  // Goal: runs on small clusters also end with the serial run's bits and lose no commit. On such a
  // cluster, one blocked worker would stop the run. Method: simulate clusters of at most four
  // workers. Use twenty times as many seeds as for large clusters.
  check_share({.method = {}, .workers_max = 4}, 20 * seeds());
}

INSTANTIATE_TEST_SUITE_P(Clusters, Seeds, testing::Range<std::uint64_t>(0, k_shares));

}  // namespace
}  // namespace sleight::cluster
