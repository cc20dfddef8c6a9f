#include <gtest/gtest.h>

#include "common/base/error.h"
#include "tests/failing/failing_ball.h"
#include "worker/run/chain_worker.h"

namespace sleight::run {
namespace {

using failing::FailingBall;

/// Counts failed simulations, independently of the chains' records.
struct Counted : FailingBall {
  explicit Counted(plan::FailureCounts& failures) : FailingBall({}), failures_(&failures) {}
  Outcome simulate(const State& state) const {
    Outcome outcome = FailingBall::simulate(state);
    if (outcome.failure) failures_->add(outcome.failure->kind);
    return outcome;
  }
  plan::FailureCounts* failures_;
};

plan::Unit unit_of(std::uint64_t seed, std::uint32_t scans, double beta, bool starts = true) {
  return {.replica = {base::ChainId{1}, base::ReplicaId{2}},
          .seed = seed,
          .first_scan = base::ScanIndex{starts ? 0U : 1U},
          .scans = scans,
          .starts = starts,
          .inverse_temperatures = {beta}};
}

plan::FailureCounts counts_of(const plan::UnitResult& result) {
  plan::FailureCounts counts;
  for (const plan::ScanRecord& scan : result.scans)
    counts.add(scan.failures);
  return counts;
}

TEST(Failures, AreNeverSamplesAndAllCounted) {
  // Goal: a chain never contains a state whose simulation fails, and the records count failed
  // simulations by kind. Method: run chains at three inverse temperatures from 0 to 1, with and
  // without excursions. Simulate the chains' states again, and compare the records' counts with the
  // simulator's counts.
  for (const double beta : {0.0, 0.3, 1.0}) {
    for (const bool excursions : {false, true}) {
      plan::FailureCounts asked;
      const ChainWorker<Counted> worker(Counted(asked), {.iterations_per_scan = 4});
      plan::Unit unit = unit_of(3, 2000, beta);
      if (excursions && beta > 0) unit.excursion = {0.5 * beta, 0};
      const plan::UnitResult result = worker.run(unit, {});
      EXPECT_EQ(counts_of(result), asked);
      EXPECT_GT(asked.total(), 50U);
      const FailingBall ball({});
      for (const plan::ScanRecord& scan : result.scans) {
        if (scan.state.empty()) continue;
        ASSERT_EQ(ball.simulate(ball.decode(scan.state).value()).failure, nullptr);
      }
    }
  }
}

TEST(Failures, ComeBackWhole) {
  // Goal: the result of a unit contains the unit's first failed simulations and their scans.
  // Simulating a failed state again gives the same failure.
  const ChainWorker<FailingBall> worker(FailingBall({}), {});
  const plan::UnitResult result = worker.run(unit_of(4, 3000, 1), {});
  ASSERT_EQ(result.failed.size(), plan::k_failed_told_max);
  const FailingBall ball({});
  std::uint64_t last = 0;
  for (const plan::FailedSimulation& failed : result.failed) {
    EXPECT_GE(failed.scan.value, last);
    last = failed.scan.value;
    EXPECT_GT(result.scans[last].failures.total(), 0U);
    const auto again = ball.simulate(ball.decode(failed.failure.state).value()).failure;
    ASSERT_NE(again, nullptr);
    EXPECT_EQ(*again, failed.failure);
  }
}

TEST(Failures, DoNotKnowHowUnitsAreCut) {
  // Goal: a chain's records, including failures, don't depend on the cuts of the chain into units,
  // or on the worker's cache. Method: compare one unit of 700 scans with units of 7 scans. Each
  // short unit starts from an encoded state. Use a worker with a cache and a worker without a
  // cache.
  const ChainWorkerOptions options{.iterations_per_scan = 3};
  const ChainWorker<FailingBall> whole(FailingBall({}), options);
  const plan::UnitResult expected = whole.run(unit_of(5, 700, 1), {});
  const ChainWorker<FailingBall> held(FailingBall({}), options);
  ChainWorkerOptions without = options;
  without.cache_bytes_max = 0;
  const ChainWorker<FailingBall> forgetful(FailingBall({}), without);
  for (const auto* worker : {&held, &forgetful}) {
    base::Bytes state;
    std::vector<plan::ScanRecord> scans;
    for (std::uint64_t first = 0; first < 700; first += 7) {
      plan::Unit unit = unit_of(5, 7, 1);
      unit.first_scan = base::ScanIndex{first};
      unit.starts = first == 0;
      if (!unit.starts) unit.lineage = scans.back().lineage;
      plan::UnitResult part = worker->run(unit, state);
      scans.insert(scans.end(), part.scans.begin(), part.scans.end());
      state = std::move(part.state_after);
    }
    ASSERT_EQ(scans.size(), expected.scans.size());
    for (std::size_t i = 0; i < scans.size(); ++i)
      ASSERT_TRUE(scans[i] == expected.scans[i]) << "scan " << i;
  }
}

TEST(Failures, DrawsFromThePriorAreDrawnAgain) {
  // Goal: at inverse temperature 0, a worker draws from a scan's random stream until a simulation
  // succeeds. The successful draw is the scan's sample.
  const ChainWorker<FailingBall> worker(FailingBall({}), {});
  const plan::UnitResult result = worker.run(unit_of(6, 1000, 0), {});
  const FailingBall ball({});
  std::uint64_t again = 0;
  for (std::uint64_t scan = 0; scan < 1000; ++scan) {
    random::Stream stream({.seed = 6,
                           .chain = base::ChainId{1},
                           .replica = base::ReplicaId{2},
                           .purpose = random::Purpose::prior},
                          scan);
    auto state = ball.draw_prior(stream);
    std::uint64_t failures = 0;
    while (ball.simulate(state).failure) {
      state = ball.draw_prior(stream);
      ++failures;
    }
    again += failures;
    ASSERT_EQ(result.scans[scan].failures.total(), failures);
    ASSERT_EQ(result.scans[scan].log_prior, ball.log_prior(state)) << "scan " << scan;
  }
  EXPECT_GT(again, 10U);
}

struct Hopeless : FailingBall {
  using FailingBall::FailingBall;
  Outcome simulate(const State& state) const {
    return {.landing = {},
            .failure = std::make_shared<const plan::SimulationFailure>(
                plan::SimulationFailure{.kind = plan::FailureKind::impact_unresolved,
                                        .message = "it never works",
                                        .state = encode(state)})};
  }
};

TEST(Failures, ThatNeverEndAreAnError) {
  // Goal: if no draw from the prior can be simulated, a worker throws an error instead of drawing
  // forever.
  const ChainWorker<Hopeless> worker(Hopeless(worlds::ball_2d::Parameters{}), {});
  try {
    worker.run(unit_of(6, 1, 1), {});
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::simulation_failed);
    EXPECT_NE(std::string(error.what()).find("it never works"), std::string::npos);
  }
}

TEST(Failures, OfAStoredStateAreABug) {
  // Goal: a worker refuses to continue from a stored state whose simulation fails. Method: start a
  // unit from the bytes of a state that failed before.
  const FailingBall ball({});
  const ChainWorker<FailingBall> worker(ball, {});
  const plan::UnitResult result = worker.run(unit_of(6, 3000, 1), {});
  ASSERT_FALSE(result.failed.empty());
  EXPECT_THROW(worker.run(unit_of(6, 5, 1, false), result.failed.front().failure.state),
               base::Error);
}

TEST(Failures, StartsThatOverlapAreSamplesAtInverseTemperatureZero) {
  // Goal: if starts overlap in a draw at inverse temperature 0, the draw is a sample, and its log
  // p_c is -infinity. The records count such draws.
  const ChainWorker<FailingBall> worker(FailingBall({}), {});
  const plan::UnitResult result = worker.run(unit_of(7, 5000, 0), {});
  std::uint64_t counted = 0;
  std::uint64_t without_density = 0;
  for (const plan::ScanRecord& scan : result.scans) {
    counted += scan.overlapping_starts;
    without_density += scan.log_constraint == -std::numeric_limits<double>::infinity() ? 1 : 0;
  }
  EXPECT_GT(counted, 50U);
  EXPECT_EQ(counted, without_density);
}

}  // namespace
}  // namespace sleight::run
