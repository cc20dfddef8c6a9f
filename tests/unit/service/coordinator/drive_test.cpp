#include "service/coordinator/drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <stdexcept>

#include "common/base/error.h"
#include "tests/unit/service/coordinator/fakes.h"
#include "worker/sampling/independent_chains.h"

namespace sleight::coordinator {
namespace {

using sampling::IndependentChains;
using store::testing::expect_stored;
using testing::FakeExecutor;
using testing::FakeExecutorOptions;

constexpr std::uint32_t k_chains = 3;

class Drive : public store::testing::RunFolder {
 protected:
  static sampling::IndependentChainsOptions scans(std::uint64_t count) {
    return {.chains = k_chains,
            .round_scans = 64,
            .stop = {.scans = count, .rounds = {}, .independent_solutions = {}}};
  }

  /// One session of the run. The executor is kept for questions.
  DriveOutcome session(const sampling::IndependentChainsOptions& plan_options,
                       const FakeExecutorOptions& executor_options,
                       const DriveOptions& options = {}) {
    IndependentChains plan(plan_options);
    executor_.emplace(clock_, executor_options);
    store_.reset();
    store_.emplace(folder(), store::testing::example_identity(k_chains));
    return drive(plan, *store_, *executor_, clock_, options);
  }

  /// Scans of all chains that a reader beside the session finds committed.
  std::uint64_t committed_scans() const {
    store::Database reader(store::RunStore::database_path(folder()), store::Access::read_only);
    store::Statement count = reader.prepare("SELECT count(*) FROM scan");
    EXPECT_TRUE(count.step());
    return static_cast<std::uint64_t>(count.integer(0));
  }

  base::ManualClock clock_;
  std::optional<store::RunStore> store_;
  std::optional<FakeExecutor> executor_;
};

TEST_F(Drive, RunsAPlanToItsEnd) {
  // Goal: every scan that the plan wants is computed once, stored, and counted. Method: 500 scans
  // of three chains; counts against the records themselves.
  const DriveOutcome outcome = session(scans(500), {.seconds_per_scan = 0.001});
  EXPECT_EQ(outcome.end, DriveEnd::finished);
  EXPECT_EQ(outcome.scans_common, 500U);
  std::uint64_t satisfied = 0;
  std::uint64_t proposed = 0;
  std::uint64_t accepted = 0;
  for (std::uint32_t chain = 0; chain < k_chains; ++chain) {
    expect_stored(folder(), *store_, chain, 500);
    for (std::uint64_t scan = 0; scan < 500; ++scan) {
      const plan::ScanRecord record = store::testing::record_of(chain, scan);
      satisfied += record.satisfied ? 1 : 0;
      proposed += std::uint64_t{record.proposed[0]} + record.proposed[1];
      accepted += std::uint64_t{record.accepted[0]} + record.accepted[1];
    }
  }
  const Progress& progress = outcome.progress;
  EXPECT_EQ(progress.scans_done, 1500U);
  EXPECT_EQ(progress.scans_total, 1500U);
  EXPECT_EQ(progress.session_scans, 1500U);
  EXPECT_EQ(progress.session_satisfied, satisfied);
  EXPECT_EQ(progress.session_proposed, proposed);
  EXPECT_EQ(progress.session_accepted, accepted);
  EXPECT_EQ(progress.workers, 3U);
  EXPECT_NEAR(progress.elapsed_s, 1.5, 1e-9);
  std::uint64_t computed = 0;
  for (const plan::Unit& unit : executor_->submitted())
    computed += unit.scans;
  EXPECT_EQ(computed, 1500U);
}

TEST_F(Drive, NothingToDoIsFinished) {
  // Goal: a finished run that is run again computes nothing. Method: two sessions; then one with a
  // nearer stop, whose archive would be cut there.
  (void)session(scans(40), {});
  const DriveOutcome again = session(scans(40), {});
  EXPECT_EQ(again.end, DriveEnd::finished);
  EXPECT_EQ(again.scans_common, 40U);
  EXPECT_TRUE(executor_->submitted().empty());
  EXPECT_EQ(again.progress.scans_done, 120U);
  EXPECT_EQ(again.progress.session_scans, 0U);
  const DriveOutcome nearer = session(scans(25), {});
  EXPECT_EQ(nearer.scans_common, 25U);
  EXPECT_TRUE(executor_->submitted().empty());
  EXPECT_EQ(nearer.progress.scans_done, 75U);
}

TEST_F(Drive, StopsWhenAskedAndLosesNothing) {
  // Goal: after a stop request nothing more is handed out, what runs ends and is stored; the next
  // session goes on from there. Method: ask after the tenth question; compare what was submitted
  // with what is stored.
  int questions = 0;
  const DriveOutcome outcome = session(scans(500), {.seconds_per_scan = 0.001},
                                       {.stop_requested = [&] { return ++questions > 10; }});
  EXPECT_EQ(outcome.end, DriveEnd::stop_requested);
  EXPECT_EQ(executor_->outstanding(), 0U);
  std::uint64_t submitted = 0;
  for (const plan::Unit& unit : executor_->submitted())
    submitted += unit.scans;
  EXPECT_EQ(committed_scans(), submitted);
  EXPECT_EQ(outcome.progress.scans_done, submitted);
  EXPECT_LT(submitted, 1500U);
  EXPECT_GT(outcome.scans_common, 0U);

  const DriveOutcome rest = session(scans(500), {.seconds_per_scan = 0.001});
  EXPECT_EQ(rest.end, DriveEnd::finished);
  EXPECT_EQ(rest.progress.session_scans, 1500U - submitted);
  EXPECT_EQ(rest.progress.scans_done, 1500U);
  for (std::uint32_t chain = 0; chain < k_chains; ++chain)
    expect_stored(folder(), *store_, chain, 500);
}

TEST_F(Drive, StopBeforeTheFirstUnit) {
  // Goal: a stop that comes before anything leaves an empty run. Method: always asked to stop.
  const DriveOutcome outcome = session(scans(5), {}, {.stop_requested = [] { return true; }});
  EXPECT_EQ(outcome.end, DriveEnd::stop_requested);
  EXPECT_EQ(outcome.scans_common, 0U);
  EXPECT_TRUE(executor_->submitted().empty());
}

TEST_F(Drive, AFinishedRunIsFinishedWhateverIsAsked) {
  // Goal: a stop request that comes after the last unit changes nothing. Method: ask always, on a
  // run that is complete.
  (void)session(scans(5), {});
  EXPECT_EQ(session(scans(5), {}, {.stop_requested = [] { return true; }}).end, DriveEnd::finished);
}

TEST_F(Drive, TimeLimitEndsInOrder) {
  // Goal: the limit is kept to within the units that run, and the cut is a whole number of scans
  // of all chains. Method: a scan takes 10 ms, the limit is 2 s.
  clock_.advance(1000);  // clocks begin anywhere
  const DriveOutcome outcome =
      session(scans(100'000), {.seconds_per_scan = 0.010}, {.time_limit_s = 2});
  EXPECT_EQ(outcome.end, DriveEnd::time_limit);
  EXPECT_GE(outcome.progress.elapsed_s, 2);
  EXPECT_LT(outcome.progress.elapsed_s, 2 + 6 * k_unit_target_s);
  EXPECT_NEAR(static_cast<double>(outcome.scans_common), 200.0 / k_chains, 10);
}

TEST_F(Drive, UnitsTakeAboutTheirTarget) {
  // Goal: units are cut to k_unit_target_s, growing at most fourfold a step, within their limit.
  // Method: a scan of 1 ms, and one that costs next to nothing.
  (void)session(scans(5000), {.seconds_per_scan = 0.001});
  EXPECT_EQ(executor_->submitted().front().scans, 1U);
  EXPECT_NEAR(executor_->submitted()[executor_->submitted().size() / 2].scans, 20, 1);
  std::filesystem::remove(store::RunStore::database_path(folder()));
  (void)session(scans(40'000), {.seconds_per_scan = 1e-9});
  std::uint32_t largest = 1;
  for (const plan::Unit& unit : executor_->submitted()) {
    EXPECT_LE(unit.scans, std::min(4 * largest, k_unit_scans_max));
    largest = std::max(largest, unit.scans);
  }
  EXPECT_EQ(largest, k_unit_scans_max);
}

TEST_F(Drive, StrangeCostsDoNoHarm) {
  // Goal: what a clock or another rank says about cost never breaks the loop. Method: costs that
  // are no time, in turn; units keep their bounds and the run its results.
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> costs{
      std::numeric_limits<double>::quiet_NaN(), -1, infinity, 0, -infinity, 1e300, 1e-300, 0.01};
  std::size_t next = 0;
  FakeExecutorOptions strange;
  strange.cost_s = [&](const plan::Unit&) { return costs[next++ % costs.size()]; };
  const DriveOutcome outcome = session(scans(300), strange);
  EXPECT_EQ(outcome.scans_common, 300U);
  for (const plan::Unit& unit : executor_->submitted()) {
    EXPECT_GE(unit.scans, 1U);
    EXPECT_LE(unit.scans, k_unit_scans_max);
  }
  expect_stored(folder(), *store_, 1, 300);
}

TEST_F(Drive, ReportsOnlyWhatIsCommitted) {
  // Goal: scans_done never runs ahead of the disk and never goes back; the last report is the
  // outcome's. Method: at each report a reader beside counts the stored scans.
  std::vector<Progress> reports;
  const auto report = [&](const Progress& progress) {
    EXPECT_LE(progress.scans_done, committed_scans());
    if (!reports.empty()) {
      EXPECT_GE(progress.scans_done, reports.back().scans_done);
    }
    reports.push_back(progress);
  };
  const DriveOutcome outcome =
      session(scans(2000), {.seconds_per_scan = 0.001}, {.report_every_s = 0.1, .report = report});
  ASSERT_GT(reports.size(), 20U);
  EXPECT_LT(reports.size(), 70U);
  EXPECT_EQ(reports.back().scans_done, 6000U);
  EXPECT_EQ(outcome.progress.scans_done, 6000U);
}

TEST_F(Drive, CheckpointsFindAllThatTheyNeed) {
  // Goal: a checkpoint comes about every checkpoint_every_s, and every chain has its scans
  // committed. Method: read the run at each, as an archive would; 60 s of work, one every 10 s.
  std::vector<std::uint64_t> cuts;
  const auto checkpoint = [&](std::uint64_t common) {
    ASSERT_GT(common, 0U);
    if (!cuts.empty()) {
      ASSERT_GT(common, cuts.back());
    }
    cuts.push_back(common);
    for (std::uint32_t chain = 0; chain < k_chains; ++chain)
      EXPECT_EQ(store::testing::stored(folder(), chain, common).size(), common);
  };
  (void)session(scans(2000), {.seconds_per_scan = 0.010},
                {.checkpoint = checkpoint, .checkpoint_every_s = 10});
  EXPECT_EQ(cuts.size(), 5U);
}

TEST_F(Drive, CostlyCheckpointsAreRare) {
  // Goal: checkpoints take a small share of a run. Method: each takes 30 s of the clock; in a run
  // of 3,000 s of work they must stay under a tenth.
  int checkpoints = 0;
  const auto checkpoint = [&](std::uint64_t) {
    ++checkpoints;
    clock_.advance(30);
  };
  (void)session(scans(1000), {.seconds_per_scan = 1},
                {.checkpoint = checkpoint, .checkpoint_every_s = 10});
  EXPECT_GE(checkpoints, 3);
  EXPECT_LE(checkpoints, 10);
}

TEST_F(Drive, WorkersFailureComesOut) {
  // Goal: a failure ends the session as it is, what came before it is stored, and the next session
  // goes on. Method: the 20th unit fails.
  int units = 0;
  FakeExecutorOptions failing{.seconds_per_scan = 0.001};
  failing.before = [&](const plan::Unit&) {
    if (++units == 20) throw std::runtime_error("the worker is gone");
  };
  EXPECT_THROW((void)session(scans(500), failing), std::runtime_error);
  store_.reset();
  EXPECT_GT(committed_scans(), 50U);
  EXPECT_EQ(session(scans(500), {.seconds_per_scan = 0.001}).end, DriveEnd::finished);
  for (std::uint32_t chain = 0; chain < k_chains; ++chain)
    expect_stored(folder(), *store_, chain, 500);
}

TEST_F(Drive, SupersededSessionEnds) {
  // Goal: a session that another has taken over from ends with conflict. Method: open the store
  // anew in the middle.
  FakeExecutorOptions options{.seconds_per_scan = 0.001};
  std::optional<store::RunStore> successor;
  int units = 0;
  options.before = [&](const plan::Unit&) {
    if (++units == 30) successor.emplace(folder(), store::testing::example_identity(k_chains));
  };
  try {
    (void)session(scans(500), options);
    ADD_FAILURE() << "no error";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::conflict);
  }
}

}  // namespace
}  // namespace sleight::coordinator
