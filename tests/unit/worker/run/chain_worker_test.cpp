#include "worker/run/chain_worker.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <thread>

#include "common/base/error.h"
#include "common/random/discrete_distributions.h"
#include "tests/support/property.h"
#include "worker/worlds/ball_2d/ball_2d.h"

namespace sleight::run {
namespace {

using worlds::ball_2d::Ball2d;
using BallWorker = ChainWorker<Ball2d>;

/// A target whose states have no encoding.
struct Unnamed : Ball2d {
  using Ball2d::Ball2d;
  base::Bytes encode(const State&) const = delete;
};

static_assert(World<Ball2d>);
static_assert(sampling::Target<Unnamed> && !World<Unnamed>);
static_assert(!World<int>);

/// A world that forbids all odd states, to test how -inf reaches the records.
struct Counter {
  using State = std::uint64_t;
  using Outcome = std::uint64_t;
  State draw_prior(random::Stream& stream) const { return stream.bits() % 100; }
  double log_prior(const State&) const { return 0; }
  Outcome simulate(const State& state) const { return state; }
  double log_constraint(const Outcome& outcome) const {
    return outcome % 2 == 0 ? 0 : -std::numeric_limits<double>::infinity();
  }
  bool satisfied(const Outcome& outcome) const { return outcome % 3 == 0; }
  sampling::Proposal<State> propose(const State& state, random::Stream& stream) const {
    const std::uint64_t step = stream.bits() % 3;
    return {.candidate = state + step, .log_q_ratio = 0, .kind = step == 2 ? 1U : 0U};
  }
  std::uint32_t proposal_kinds() const { return 2; }
  std::size_t owned_bytes(const State&, const Outcome&) const { return 0; }
  base::Bytes encode(const State& state) const {
    base::ByteWriter writer;
    writer.put(state);
    return writer.take();
  }
  std::optional<State> decode(base::BytesView bytes) const {
    return base::ByteReader(bytes).get<std::uint64_t>();
  }
  std::vector<double> outcome_values(const Outcome& outcome) const {
    return {static_cast<double>(outcome)};
  }
};
static_assert(World<Counter>);

plan::Unit unit(std::uint32_t chain, std::uint64_t first, std::uint32_t scans, double beta = 1) {
  return {.replica = {base::ChainId{chain}, base::ReplicaId{0}},
          .seed = 11,
          .first_scan = base::ScanIndex{first},
          .scans = scans,
          .starts = first == 0,
          .lineage = 0,
          .inverse_temperatures = {beta}};
}

template <class Worker>
plan::UnitResult run_in_units(const Worker& worker, std::uint32_t chain,
                              const std::vector<std::uint32_t>& sizes) {
  plan::UnitResult all;
  for (const std::uint32_t scans : sizes) {
    const plan::UnitResult part = worker.run(unit(chain, all.scans.size(), scans), all.state_after);
    EXPECT_EQ(part.unit, unit(chain, all.scans.size(), scans));
    EXPECT_EQ(part.scans.size(), scans);
    all.scans.insert(all.scans.end(), part.scans.begin(), part.scans.end());
    all.state_after = part.state_after;
  }
  return all;
}

/// Expects equal records and states. These worlds have no NaN, so == misses only the sign of zero.
/// A comparison of the outcomes' bits detects a different sign.
void expect_equal(const plan::UnitResult& a, const plan::UnitResult& b) {
  ASSERT_EQ(a.scans.size(), b.scans.size());
  for (std::size_t i = 0; i < a.scans.size(); ++i) {
    ASSERT_EQ(a.scans[i], b.scans[i]) << "scan " << i;
    for (std::size_t j = 0; j < a.scans[i].outcome.size(); ++j) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a.scans[i].outcome[j]),
                std::bit_cast<std::uint64_t>(b.scans[i].outcome[j]));
    }
  }
  EXPECT_EQ(a.state_after, b.state_after);
}

BallWorker ball_worker(std::uint32_t iterations_per_scan = 1, std::uint64_t thin = 1) {
  return BallWorker(Ball2d({}), {.iterations_per_scan = iterations_per_scan, .thin = thin});
}

TEST(ChainWorker, ResultsDoNotKnowHowUnitsAreCut) {
  // Goal: a chain's stored results don't depend on how the chain is cut into units. Method: cut 300
  // scans into random units, and compare the results with one unit of 300 scans. Repeat this 200
  // times. Use two worlds and several options.
  constexpr std::uint64_t k_seed = 5;
  constexpr std::uint32_t k_scans = 300;
  const auto check = [&](const auto& worker) {
    const plan::UnitResult whole = run_in_units(worker, 3, {k_scans});
    for (const std::uint64_t trial : property::cases(50)) {
      random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, trial);
      const std::uint64_t longest = random::UniformInteger{.count = 80}.draw(stream) + 1;
      std::vector<std::uint32_t> sizes;
      std::uint32_t left = k_scans;
      while (left > 0) {
        const auto scans = static_cast<std::uint32_t>(
            1 +
            random::UniformInteger{.count = std::min<std::uint64_t>(longest, left)}.draw(stream));
        sizes.push_back(scans);
        left -= scans;
      }
      expect_equal(run_in_units(worker, 3, sizes), whole);
      if (::testing::Test::HasFailure()) return;
    }
  };
  check(ball_worker());
  check(ball_worker(3, 7));
  check(ChainWorker<Counter>(Counter{}, {.thin = 5}));
  check(ChainWorker<Counter>(Counter{}, {.iterations_per_scan = 4}));
}

TEST(ChainWorker, IsPure) {
  // Goal: a worker's result depends only on the unit. Other threads and earlier units don't matter.
  // Method: in four threads, run units of six chains in different orders. Run each chain twice.
  // Compare with the results of a single thread.
  const BallWorker worker = ball_worker();
  std::vector<plan::UnitResult> reference;
  for (std::uint32_t chain = 0; chain < 6; ++chain)
    reference.push_back(run_in_units(worker, chain, {40, 60}));
  std::vector<std::thread> threads;
  for (std::uint32_t thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&, thread] {
      for (std::uint32_t i = 0; i < 12; ++i) {
        const std::uint32_t chain = (5 * i + thread) % 6;
        expect_equal(run_in_units(worker, chain, {40, 60}), reference[chain]);
      }
    });
  }
  for (std::thread& thread : threads)
    thread.join();
}

TEST(ChainWorker, WalksByIterationsFromOne) {
  // Goal: with k iterations per scan, scan s consists of iterations (s - 1) k + 1 to s k of
  // Algorithm 2.1. Other iterations would change the random numbers that a chain draws. Method:
  // compare the worker's states with a loop over single steps.
  const Ball2d ball({});
  const sampling::ChainStreams streams{
      .seed = 11, .chain = base::ChainId{4}, .replica = base::ReplicaId{0}};
  const plan::UnitResult result = ball_worker(3).run(unit(4, 0, 30), {});
  auto sample = sampling::draw_afresh(ball, streams, 0);
  std::uint64_t iteration = 0;
  for (std::size_t scan = 1; scan < 30; ++scan) {
    for (int i = 0; i < 3; ++i)
      sampling::metropolis_hastings_step(ball, 1, streams, ++iteration, sample);
    ASSERT_EQ(result.scans[scan].state, ball.encode(sample.state)) << scan;
  }
}

TEST(ChainWorker, UsesTheUnitsInverseTemperature) {
  // Goal: a worker runs a unit at the unit's inverse temperature beta. At beta 0, each scan is a
  // new prior draw with its own lineage. The scan's record still contains log p_c at beta 1.
  // Method: use a world that forbids half of all states. Forbidden states must occur at beta 0, and
  // never at a small positive beta.
  const ChainWorker<Counter> worker(Counter{}, {});
  const base::Bytes start = Counter{}.encode(100);
  std::uint64_t forbidden = 0;
  std::uint64_t before = 0;
  for (const plan::ScanRecord& scan : worker.run(unit(0, 1, 500, 0), start).scans) {
    EXPECT_EQ(scan.proposed[0] + scan.proposed[1], 0U);
    EXPECT_EQ(scan.inverse_temperature, 0);
    EXPECT_GT(scan.lineage, before);
    before = scan.lineage;
    if (std::isinf(scan.log_constraint)) ++forbidden;
  }
  EXPECT_GT(forbidden, 100U);
  for (const plan::ScanRecord& scan : worker.run(unit(0, 1, 500, 1e-9), start).scans)
    EXPECT_EQ(scan.log_constraint, 0);
}

TEST(ChainWorker, CountsByKind) {
  // Goal: a record counts proposals and acceptances separately for each kind of proposal. Method:
  // use a world with two kinds. A proposal of kind 1 adds two to the state and is always accepted
  // from allowed states.
  const ChainWorker<Counter> worker(Counter{}, {.iterations_per_scan = 50});
  const plan::UnitResult result = worker.run(unit(0, 1, 20), Counter{}.encode(0));
  double before = 0;
  for (const plan::ScanRecord& scan : result.scans) {
    EXPECT_EQ(scan.proposed[0] + scan.proposed[1], 50U);
    EXPECT_EQ(scan.accepted[1], scan.proposed[1]);
    EXPECT_LT(scan.accepted[0], scan.proposed[0]);
    EXPECT_EQ(scan.outcome[0], before + 2 * scan.accepted[1]);
    before = scan.outcome[0];
  }
}

TEST(ChainWorkerDeathTest, MisuseIsABug) {
  // Goal: a worker stops the process if a unit has no scans.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const BallWorker worker = ball_worker();
  EXPECT_DEATH((void)worker.run(unit(0, 0, 0), {}), "check failed");
}

TEST(ChainWorker, DamagedStateIsAnErrorWithAdvice) {
  // Goal: a worker throws an error if the bytes of a stored state are damaged. Method: run units
  // from no bytes and from too few bytes.
  const BallWorker worker = ball_worker();
  EXPECT_THROW((void)worker.run(unit(0, 1, 1), {}), base::Error);
  EXPECT_THROW((void)worker.run(unit(0, 1, 1), base::Bytes(39)), base::Error);
}

}  // namespace
}  // namespace sleight::run
