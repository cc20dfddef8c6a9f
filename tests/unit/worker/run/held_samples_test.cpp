#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "tests/support/property.h"
#include "worker/run/chain_worker.h"
#include "worker/worlds/ball_2d/ball_2d.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::run::held_samples_test {

using worlds::ball_2d::Ball2d;
using worlds::spelling::Spelling;

constexpr std::uint64_t k_seed = 137035;

plan::ReplicaKey key(std::uint32_t chain, std::uint32_t replica = 0) {
  return {base::ChainId{chain}, base::ReplicaId{replica}};
}

plan::Unit unit(const plan::ReplicaKey& replica, std::uint64_t first, std::uint32_t scans,
                double beta = 1) {
  return {.replica = replica,
          .seed = k_seed,
          .first_scan = base::ScanIndex{first},
          .scans = scans,
          .starts = first == 0,
          .lineage = 0,
          .inverse_temperatures = {beta}};
}

worlds::spelling::Parameters two_bins() {
  worlds::spelling::Parameters parameters;
  parameters.pattern = worlds::spelling::pattern_of_rows("##").value();
  return parameters;
}

/// Number of simulations, shared by all copies of a world.
using Count = std::shared_ptr<std::atomic<std::uint64_t>>;

template <class W>
struct Counted : W {
  template <class Parameters>
  Counted(const Parameters& parameters, Count simulations)
      : W(parameters), count(std::move(simulations)) {}
  typename W::Outcome simulate(const typename W::State& state) const {
    ++*count;
    return W::simulate(state);
  }
  typename W::Outcome simulate_from(
      const typename W::State& candidate, const typename W::State& state,
      const typename W::Outcome& outcome) const requires sampling::SimulatesChanges<W> {
    ++*count;
    return W::simulate_from(candidate, state, outcome);
  }
  Count count;
};
static_assert(World<Counted<Ball2d>> && World<Counted<Spelling>>);
static_assert(sampling::HasSurrogate<Counted<Spelling>>);

/// A random unit. The unit has one random inverse temperature for all scans, a random inverse
/// temperature for each scan, or an excursion.
plan::Unit random_unit(const plan::ReplicaKey& replica, std::uint64_t first,
                       random::Stream& stream) {
  const auto below = [&](std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream);
  };
  plan::Unit made = unit(replica, first, static_cast<std::uint32_t>(1 + below(5)));
  const std::vector<double> betas{0, 0.1, 0.5, 1};
  switch (below(3)) {
    case 0:
      made.inverse_temperatures.clear();
      for (std::uint32_t nth = 0; nth < made.scans; ++nth)
        made.inverse_temperatures.push_back(betas[below(4)]);
      break;
    case 1:
      made.excursion = {0.5, 0.1, 0};
      break;
    default:
      made.inverse_temperatures = {betas[below(4)]};
  }
  return made;
}

/// A replica, and whether a worker holds its newest sample.
struct Replica {
  std::uint64_t next = 0;
  std::uint64_t lineage = 0;
  base::Bytes state;
  bool held = false;
};

/// Runs random units of six replicas. Two workers run the same units and must have equal results.
/// One worker continues from held samples if it can. The other worker holds no samples and
/// continues from encoded states.
template <class MakeWorld>
void expect_held_equals_given(const MakeWorld& make_world, ChainWorkerOptions options) {
  const auto held_count = std::make_shared<std::atomic<std::uint64_t>>(0);
  const auto given_count = std::make_shared<std::atomic<std::uint64_t>>(0);
  const ChainWorker holder(make_world(held_count), options);
  options.cache_bytes_max = 0;
  const ChainWorker forgetter(make_world(given_count), options);
  std::vector<Replica> replicas(6);
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, 0);
  std::uint64_t hits = 0;
  std::uint64_t misses = 0;
  for ([[maybe_unused]] const std::uint64_t turn : property::in_turn(200)) {
    const auto id = static_cast<std::uint32_t>(random::UniformInteger{.count = 6}.draw(stream));
    Replica& replica = replicas[id];
    plan::Unit next = random_unit(key(id / 2, id % 2), replica.next, stream);
    next.lineage = replica.lineage;

    const std::uint64_t given_before = *given_count;
    const plan::UnitResult given = forgetter.run(next, replica.state);
    EXPECT_EQ(given.simulations, *given_count - given_before);

    const std::uint64_t held_before = *held_count;
    std::optional<plan::UnitResult> result;
    if (!next.starts) {
      result = holder.run_from_held(next);
      ASSERT_EQ(result.has_value(), replica.held);
      (result ? hits : misses) += 1;
    }
    if (!result) result = holder.run(next, replica.state);
    EXPECT_EQ(result->simulations, *held_count - held_before);
    ASSERT_EQ(result->unit, given.unit);
    ASSERT_EQ(result->scans, given.scans);
    ASSERT_EQ(result->state_after, given.state_after);
    // A held sample saves only the simulation of the state before the unit.
    EXPECT_EQ(given.simulations - result->simulations, !next.starts && replica.held ? 1U : 0U);
    replica.held = true;
    // Drop every seventh result, so that the held sample belongs to another scan.
    if (turn % 7 == 3) {
      replica.held = false;
      continue;
    }
    replica = {.next = replica.next + next.scans,
               .lineage = given.scans.back().lineage,
               .state = given.state_after,
               .held = true};
  }
  if (!property::all_cases()) return;
  EXPECT_GT(hits, 50U);
  EXPECT_GT(misses, 10U);
}

TEST(HeldSamples, GiveWhatBytesGive) {
  // Goal: run_from_held() returns the same bits as run() with the state's bytes, or nothing if the
  // worker doesn't hold the sample. The result's field `simulations` counts all of the target's
  // simulations. Method: use worlds that count their simulations. Compare two workers, of which
  // only one has a cache. Run units at several inverse temperatures. Some runs have excursions,
  // some have a surrogate, and some have several iterations per scan.
  expect_held_equals_given(
      [](Count count) { return Counted<Ball2d>(worlds::ball_2d::Parameters{}, std::move(count)); },
      {.iterations_per_scan = 2});
  worlds::spelling::Parameters spelling = two_bins();
  for (const std::uint32_t solo_steps : {0U, 3U}) {
    spelling.proposal.solo_steps = solo_steps;
    expect_held_equals_given(
        [&](Count count) { return Counted<Spelling>(spelling, std::move(count)); },
        {.iterations_per_scan = 2, .thin = 3, .first_draw = 4});
  }
}

TEST(HeldSamples, AreGivenUpWithinTheirBytes) {
  // Goal: if a worker's cache is full, the worker evicts the sample whose replica ran longest ago.
  // Method: run five replicas with a cache that has room for three samples. Run one replica with a
  // cache that is too small for any sample.
  const ChainWorker<Ball2d> roomy(Ball2d({}), {});
  (void)roomy.run(unit(key(0), 0, 3), {});
  const std::size_t one = roomy.cache_use().bytes;
  EXPECT_GE(one, sizeof(sampling::Sample<Ball2d>));
  const ChainWorker<Ball2d> worker(Ball2d({}), {.cache_bytes_max = 3 * one + one / 2});
  for (std::uint32_t chain = 0; chain < 5; ++chain)
    (void)worker.run(unit(key(chain), 0, 3), {});
  EXPECT_EQ(worker.cache_use().evictions, 2U);
  EXPECT_EQ(worker.cache_use().bytes, 3 * one);
  for (std::uint32_t chain = 0; chain < 5; ++chain)
    EXPECT_EQ(worker.run_from_held(unit(key(chain), 3, 1)).has_value(), chain >= 2) << chain;

  const ChainWorker<Ball2d> none(Ball2d({}), {.cache_bytes_max = one - 1});
  (void)none.run(unit(key(0), 0, 3), {});
  EXPECT_FALSE(none.run_from_held(unit(key(0), 3, 1)));
  EXPECT_EQ(none.cache_use().bytes, 0U);
}

TEST(HeldSamplesDeathTest, MisuseIsABug) {
  // Goal: if a unit begins at scan 0, run_from_held() and holds() stop the process. If a unit has
  // no scans, run_from_held() stops the process.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const ChainWorker<Ball2d> worker(Ball2d({}), {});
  EXPECT_DEATH((void)worker.run_from_held(unit(key(0), 0, 1)), "check failed");
  EXPECT_DEATH((void)worker.run_from_held(unit(key(0), 1, 0)), "check failed");
  EXPECT_DEATH((void)worker.holds(unit(key(0), 0, 1)), "check failed");
}

TEST(HeldSamples, OwnedBytesCoverAllArrays) {
  // Goal: the size that a world reports for a sample covers all of the sample's arrays, including
  // the surrogate's outcome and the history. The size is at most 64 bytes larger than these arrays
  // and the history's objects together. Method: for 50 prior draws, compare the size with the sum
  // of the arrays' capacities. Some draws have spare capacity. Some draws are impossible, so their
  // outcome has no arrays.
  worlds::spelling::Parameters parameters = two_bins();
  parameters.world.drop_interval_s = 0.001;
  const Spelling world(parameters);
  random::Stream stream({.seed = k_seed, .purpose = random::Purpose::start}, 0);
  const auto arrays_bytes = [&](const Spelling::State& state, const Spelling::Outcome& outcome) {
    const auto solo = world.surrogate({}).simulate(state);
    const auto bytes = [](const auto& array) {
      return array.capacity() * sizeof(typename std::decay_t<decltype(array)>::value_type);
    };
    std::size_t all = bytes(state.offsets_m) + bytes(state.active) + bytes(state.drops_m) +
                      bytes(outcome.filling) + bytes(solo.alone) + bytes(solo.filling);
    if (!outcome.history) return all;
    for (const auto& history : outcome.history->histories) {
      if (!history) continue;
      all += bytes(history->parts) + bytes(history->flights) + bytes(history->checkpoints) +
             bytes(history->meetings) + bytes(history->touches) + bytes(history->met);
    }
    return all + bytes(outcome.history->looks) + bytes(outcome.history->seen) +
           bytes(outcome.history->flat_edges);
  };
  const auto objects_bytes = [](const Spelling::Outcome& outcome) -> std::size_t {
    if (!outcome.history) return 0;
    const worlds::spelling::SpellingHistory& history = *outcome.history;
    return sizeof(history) + history.histories.size() * (16 + sizeof(physics::MarbleHistory));
  };
  int with_history = 0;
  for (int draw = 0; draw < 50; ++draw) {
    Spelling::State state = world.draw_prior(stream);
    if (draw % 5 == 4) {  // drop all balls at one place, too soon after each other
      std::ranges::fill(state.drops_m, state.drops_m[0]);
      std::ranges::fill(state.active, std::uint8_t{1});
    }
    if (draw % 5 == 3) {
      state.offsets_m.reserve(500);
      state.active.reserve(300);
      state.drops_m.reserve(200);
    }
    const Spelling::Outcome outcome = world.simulate_from(state, state, {});
    if (outcome.history) ++with_history;
    if (draw % 5 == 4) {
      EXPECT_EQ(outcome.end, worlds::spelling::End::impossible);
    }
    EXPECT_GE(world.owned_bytes(state, outcome), arrays_bytes(state, outcome)) << draw;
    EXPECT_LE(world.owned_bytes(state, outcome),
              arrays_bytes(state, outcome) + objects_bytes(outcome) + 64)
        << draw;
  }
  EXPECT_GE(with_history, 25);
  EXPECT_EQ(Ball2d({}).owned_bytes({}, {}), 0U);
}

}  // namespace sleight::run::held_samples_test
