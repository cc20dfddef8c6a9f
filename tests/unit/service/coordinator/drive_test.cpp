#include "service/coordinator/drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "common/base/error.h"
#include "service/core/block_size.h"
#include "tests/unit/service/coordinator/fakes.h"
#include "worker/sampling/independent_chains.h"

namespace sleight::coordinator {
namespace {

using sampling::IndependentChains;
using store::testing::expect_stored;
using testing::FakeCrew;
using testing::FakeCrewOptions;

constexpr std::uint32_t k_chains = 3;

class Drive : public store::testing::RunFolder {
 protected:
  static sampling::IndependentChainsOptions scans(std::uint64_t count) {
    return {.chains = k_chains,
            .round_scans = 64,
            .stop = {.scans = count, .rounds = {}, .independent_solutions = {}}};
  }

  /// Runs one session. The crew stays available for checks.
  DriveOutcome session(const sampling::IndependentChainsOptions& plan_options,
                       const FakeCrewOptions& crew_options, const DriveOptions& options = {}) {
    IndependentChains plan(plan_options);
    crew_.emplace(clock_, crew_options);
    store_.reset();
    store_.emplace(folder(), store::testing::example_identity(k_chains));
    return drive(plan, *store_, *crew_, clock_, options);
  }

  /// Counts the committed scans of all chains with a second reader.
  std::uint64_t committed_scans() const {
    store::Database reader(store::RunStore::database_path(folder()), store::Access::read_only);
    store::Statement count = reader.prepare("SELECT count(*) FROM scan");
    EXPECT_TRUE(count.step());
    return static_cast<std::uint64_t>(count.integer(0));
  }

  base::ManualClock clock_;
  std::optional<store::RunStore> store_;
  std::optional<FakeCrew> crew_;
};

TEST_F(Drive, RunsAPlanToItsEnd) {
  // Goal: every scan of the plan is computed once, stored and counted. Method: run 500 scans of
  // three chains, and compare the reported counts with counts over the example records.
  const DriveOutcome outcome = session(scans(500), {.seconds_per_scan = 0.001});
  EXPECT_EQ(outcome.end, DriveEnd::finished);
  EXPECT_EQ(outcome.reached.scans, 500U);
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
  const events::Progress& progress = outcome.progress;
  EXPECT_EQ(progress.scans_done, 1500U);
  EXPECT_EQ(progress.scans_total, 1500U);
  EXPECT_EQ(progress.session_scans, 1500U);
  EXPECT_EQ(progress.session_satisfied, satisfied);
  EXPECT_EQ(progress.session_proposed, proposed);
  EXPECT_EQ(progress.session_accepted, accepted);
  EXPECT_EQ(progress.workers, 3U);
  EXPECT_NEAR(progress.elapsed_s, 1.5, 1e-9);
  std::uint64_t computed = 0;
  for (const plan::Unit& unit : crew_->submitted())
    computed += unit.scans;
  EXPECT_EQ(computed, 1500U);
  // The example crew reports 2 n + 1 simulations for a unit of n scans.
  EXPECT_EQ(progress.session_simulations, 2 * 1500U + crew_->submitted().size());
  EXPECT_FALSE(progress.round_trips.has_value());
}

TEST_F(Drive, StopsWhenAskedAndLosesNothing) {
  // Goal: after a stop request, the session assigns no more blocks. The session finishes the
  // running blocks and stores their results. The next session resumes the run. Method: request a
  // stop after ten checks. The number of stored scans must equal the number of submitted scans.
  int questions = 0;
  const DriveOutcome outcome = session(scans(500), {.seconds_per_scan = 0.001},
                                       {.stop_requested = [&] { return ++questions > 10; }});
  EXPECT_EQ(outcome.end, DriveEnd::stop_requested);
  EXPECT_EQ(crew_->outstanding(), 0U);
  std::uint64_t submitted = 0;
  for (const plan::Unit& unit : crew_->submitted())
    submitted += unit.scans;
  EXPECT_EQ(committed_scans(), submitted);
  EXPECT_EQ(outcome.progress.scans_done, submitted);
  EXPECT_LT(submitted, 1500U);
  EXPECT_GT(outcome.reached.scans, 0U);

  const DriveOutcome rest = session(scans(500), {.seconds_per_scan = 0.001});
  EXPECT_EQ(rest.end, DriveEnd::finished);
  EXPECT_EQ(rest.progress.session_scans, 1500U - submitted);
  EXPECT_EQ(rest.progress.scans_done, 1500U);
  for (std::uint32_t chain = 0; chain < k_chains; ++chain)
    expect_stored(folder(), *store_, chain, 500);
}

TEST_F(Drive, AFinishedRunIsFinishedWhateverIsAsked) {
  // Goal: a stop request has no effect if the run is complete.
  (void)session(scans(5), {});
  EXPECT_EQ(session(scans(5), {}, {.stop_requested = [] { return true; }}).end, DriveEnd::finished);
}

TEST_F(Drive, TimeLimitEndsInOrder) {
  // Goal: a session exceeds its time limit only by the time of its running units, and cuts all
  // chains at the same scan. Method: let each scan take 10 ms, and set a limit of 2 s.
  clock_.advance(1000);  // a clock may start at any time
  const DriveOutcome outcome =
      session(scans(100'000), {.seconds_per_scan = 0.010}, {.time_limit_s = 2});
  EXPECT_EQ(outcome.end, DriveEnd::time_limit);
  EXPECT_GE(outcome.progress.elapsed_s, 2);
  // At the limit, at most six units are assigned.
  EXPECT_LT(outcome.progress.elapsed_s, 2.005 + 6 * core::BlockSizeOptions{}.target_s);
  EXPECT_NEAR(static_cast<double>(outcome.reached.scans), 200.0 / k_chains, 10);
}

TEST_F(Drive, UnitsFollowWhatScansCost) {
  // Goal: measured costs determine the sizes of units (see block_size_test). Units grow until they
  // take the target duration. If scans are cheap, units grow to the maximum block size. Method: run
  // scans of 0.5 ms, and scans that cost almost nothing.
  const core::BlockSizeOptions size{};
  (void)session(scans(5000), {.seconds_per_scan = 0.0005});
  EXPECT_EQ(crew_->submitted().front().scans, 1U);
  EXPECT_NEAR(crew_->submitted()[crew_->submitted().size() / 2].scans, size.target_s / 0.0005, 1);
  std::filesystem::remove(store::RunStore::database_path(folder()));
  (void)session(scans(40'000), {.seconds_per_scan = 1e-9});
  std::uint32_t largest = 1;
  for (const plan::Unit& unit : crew_->submitted()) {
    EXPECT_LE(unit.scans, std::min(8 * largest, size.scans_max));
    largest = std::max(largest, unit.scans);
  }
  EXPECT_EQ(largest, size.scans_max);
}

TEST_F(Drive, ReportsOnlyWhatIsCommitted) {
  // Goal: the reported scans_done never exceeds the committed scans and never decreases; the last
  // report equals the outcome's progress. Method: at each report, count the stored scans with a
  // second reader.
  std::vector<events::Progress> reports;
  const auto report = [&](const events::Progress& progress) {
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

TEST_F(Drive, DoesNotWaitForWhatTakesLong) {
  // Goal: a stop request ends the session soon, even if blocks are still running, and keeps all
  // results so far. The next session computes the rest. Method: let the crew hang after 3 s, and
  // request a stop after 5 s. Without the grace limit the test would never end.
  const double begin_s = clock_.now_s();
  const DriveOutcome cut =
      session(scans(2000), {.seconds_per_scan = 0.001, .hangs_from_s = begin_s + 3},
              {.stop_requested = [&] { return clock_.now_s() >= begin_s + 5; }});
  EXPECT_EQ(cut.end, DriveEnd::stop_requested);
  EXPECT_GE(clock_.now_s() - begin_s, 5 + k_stop_grace_s);
  EXPECT_LT(clock_.now_s() - begin_s, 5 + k_stop_grace_s + 1);
  EXPECT_GT(crew_->outstanding(), 0U);
  EXPECT_GE(committed_scans(), 2500U);
  EXPECT_LT(committed_scans(), 6000U);
  const DriveOutcome rest = session(scans(2000), {.seconds_per_scan = 0.001});
  EXPECT_EQ(rest.end, DriveEnd::finished);
  EXPECT_EQ(committed_scans(), 6000U);
}

TEST_F(Drive, SaysWhatIsReachedAndWhetherThereIsASolution) {
  // Goal: the cuts that the callback `standing` gets never shrink. After the first solution,
  // has_solution stays true. A flush commits the scans of the cut. Method: at each call, flush and
  // read the store.
  std::vector<std::uint64_t> cuts;
  bool had_solution = false;
  const auto standing = [&](const Standing& now) {
    const std::uint64_t scans_now = now.reached.scans;
    EXPECT_GE(scans_now, cuts.empty() ? 0 : cuts.back());
    EXPECT_TRUE(now.has_solution || !had_solution);
    EXPECT_EQ(now.workers, 3U);
    had_solution = now.has_solution;
    cuts.push_back(scans_now);
    store_->flush();
    for (std::uint32_t chain = 0; scans_now > 0 && chain < k_chains; ++chain)
      EXPECT_EQ(store::testing::stored(folder(), chain, scans_now).size(), scans_now);
  };
  (void)session(scans(2000), {.seconds_per_scan = 0.010},
                {.report_every_s = 5, .standing = standing});
  EXPECT_GE(cuts.size(), 10U);
  EXPECT_LE(cuts.size(), 13U);
  EXPECT_TRUE(had_solution);
}

TEST_F(Drive, WorkersFailureComesOut) {
  // Goal: a worker's exception ends the session and reaches the caller. Earlier results are stored,
  // and the next session resumes the run. Method: let the 40th unit throw an exception.
  int units = 0;
  std::uint64_t scans_before = 0;
  FakeCrewOptions failing{.seconds_per_scan = 0.001};
  failing.before = [&](const plan::Unit& unit) {
    if (++units == 40) throw std::runtime_error("the worker is gone");
    scans_before += unit.scans;
  };
  EXPECT_THROW((void)session(scans(500), failing), std::runtime_error);
  store_.reset();
  EXPECT_GT(scans_before, 50U);
  EXPECT_EQ(committed_scans(), scans_before);
  EXPECT_EQ(session(scans(500), {.seconds_per_scan = 0.001}).end, DriveEnd::finished);
  for (std::uint32_t chain = 0; chain < k_chains; ++chain)
    expect_stored(folder(), *store_, chain, 500);
}

TEST_F(Drive, SupersededSessionEnds) {
  // Goal: a session ends with a conflict if another session takes over its run. Method: open the
  // run's store a second time during the session.
  FakeCrewOptions options{.seconds_per_scan = 0.001};
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

TEST_F(Drive, SaysWhatHandlingTook) {
  // Goal: an outcome's `handling` has the scheduler's counts and the crew's messages. `handling`
  // also has the sum of the cache numbers that the workers reported last. Method: compare
  // `handling` with the counts of a crew of three workers. The workers' cache numbers grow with
  // each delivery.
  const DriveOutcome outcome =
      session(scans(400), {.workers = 3, .threads = 2, .seconds_per_scan = 0.001});
  EXPECT_EQ(outcome.progress.workers, 6U);
  const core::Counts& counts = outcome.handling.counts;
  EXPECT_EQ(counts.scans, 400U * k_chains);
  EXPECT_EQ(counts.blocks, crew_->submitted().size());
  EXPECT_EQ(counts.copies, 0U);
  EXPECT_EQ(counts.refused, 0U);
  EXPECT_EQ(counts.states_missing, 0U);
  EXPECT_EQ(counts.states_held, crew_->states_held());
  EXPECT_EQ(counts.states_sent, crew_->states_given());
  EXPECT_EQ(counts.states_held + counts.states_sent,
            counts.blocks - k_chains);  // each chain's first block has no state
  EXPECT_EQ(outcome.handling.traffic.messages, crew_->submitted().size());
  EXPECT_EQ(outcome.handling.traffic.bytes, 100 * crew_->submitted().size());

  plan::CacheUse expected;
  for (std::uint32_t worker = 0; worker < 3; ++worker) {
    const std::uint64_t hits = crew_->deliveries(core::WorkerId{worker}) * (worker + 1);
    EXPECT_GT(hits, 0U);
    expected.hits += hits;
    expected.misses += 10 * hits;
    expected.evictions += 100 * hits;
    expected.bytes += 1000 * hits;
    expected.bytes_max += 10'000 * (worker + 1);
  }
  EXPECT_EQ(outcome.handling.cache, expected);
}

TEST_F(Drive, NobodyIsSilentSinceTheClockIsOld) {
  // Goal: even if the clock starts at a large time, no worker counts as silent, and no lease ends.
  clock_.advance(1e6);
  const DriveOutcome outcome =
      session(scans(1000), {.workers = 2, .threads = 2, .seconds_per_scan = 1}, {});
  EXPECT_EQ(outcome.handling.counts.copies, 0U);
  EXPECT_EQ(crew_->submitted().size(), outcome.handling.counts.blocks);
  EXPECT_EQ(crew_->pings(), 0U);
}

TEST_F(Drive, ReportsRoundTripsOfItsPlan) {
  // Goal: if the plan counts round trips, a session's progress includes the round trips of all
  // sessions. Method: run two sessions. The second session's plan counts each consumed scan as a
  // round trip.
  class Travelling final : public plan::Plan {
   public:
    explicit Travelling(const sampling::IndependentChainsOptions& options) : chains_(options) {}
    std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override {
      return chains_.next_unit(scans_max);
    }
    void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                 std::span<const plan::ScanRecord> records) override {
      chains_.consume(replica, first_scan, records);
    }
    bool finished() const override { return chains_.finished(); }
    std::uint64_t scans_common() const override { return chains_.scans_common(); }
    std::uint64_t solutions_found() const override { return chains_.solutions_found(); }
    std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                  std::uint64_t until) const override {
      return chains_.solutions_between(after, until);
    }
    std::optional<std::uint64_t> solutions_wanted() const override { return std::nullopt; }
    std::optional<std::uint64_t> round_trips() const override { return scans_consumed(); }
    std::uint64_t scans_consumed() const override { return chains_.scans_consumed(); }
    std::optional<std::uint64_t> scans_total() const override { return std::nullopt; }

   private:
    IndependentChains chains_;
  };
  (void)session(scans(50), {});
  Travelling plan(scans(80));
  FakeCrew crew(clock_, {.seconds_per_scan = 0.001});
  store_.reset();
  store_.emplace(folder(), store::testing::example_identity(k_chains));
  std::vector<std::uint64_t> reported;
  const DriveOutcome outcome =
      drive(plan, *store_, crew, clock_,
            {.report_every_s = 0, .report = [&](const events::Progress& now) {
               reported.push_back(now.round_trips.value_or(0));
             }});
  EXPECT_EQ(outcome.progress.round_trips, 80U * k_chains);
  EXPECT_EQ(outcome.progress.session_simulations, 2 * 30U * k_chains + crew.submitted().size());
  ASSERT_GT(reported.size(), 2U);
  EXPECT_GE(reported.front(), 50U * k_chains);
  EXPECT_TRUE(std::ranges::is_sorted(reported));
}

}  // namespace
}  // namespace sleight::coordinator
