// Measures how many independent solutions a method finds per simulation, for docs/MEASUREMENTS.
#pragma once

#include <ctime>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "worker/run/chain_worker.h"
#include "worker/run/search_start.h"
#include "worker/sampling/annealed_importance.h"
#include "worker/sampling/burnt_in_chains.h"
#include "worker/sampling/excursions.h"
#include "worker/sampling/judged_chains.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/parallel_tempering.h"
#include "worker/sampling/restarted_chains.h"
#include "worker/sampling/search_lanes.h"
#include "worker/sampling/simulated_tempering.h"

namespace sleight::thesis {

struct Score {
  std::uint64_t simulations = 0;
  std::uint64_t solutions = 0;
  double cpu_s = 0;
};

inline double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A world that counts its simulations. Not thread-safe.
template <class World>
struct Counted : World {
  template <class Parameters>
  Counted(const Parameters& parameters, std::uint64_t& count) : World(parameters), count_(&count) {}
  typename World::Outcome simulate(const typename World::State& state) const {
    ++*count_;
    return World::simulate(state);
  }
  typename World::Outcome simulate_from(
      const typename World::State& candidate, const typename World::State& state,
      const typename World::Outcome& outcome) const requires sampling::SimulatesChanges<World> {
    ++*count_;
    return World::simulate_from(candidate, state, outcome);
  }
  std::uint64_t* count_;
};

/// Runs Algorithm 2.1, and restarts it from the prior after each first hit. Let m be the mean
/// number of simulations before a hit. The ratio of solutions to simulations estimates 1/m.
template <class World, class Parameters>
Score restarted_chains(const Parameters& parameters, std::uint64_t seed,
                       std::uint64_t simulations) {
  Score score;
  const Counted<World> world(parameters, score.simulations);
  const double begin_s = thread_cpu_s();
  for (std::uint32_t chain = 0; score.simulations < simulations; ++chain) {
    const sampling::ChainStreams streams{
        .seed = seed, .chain = base::ChainId{chain}, .replica = {}};
    auto sample = sampling::draw_afresh(world, streams, 0);
    for (std::uint64_t i = 1; score.simulations < simulations && !world.satisfied(sample.outcome);
         ++i)
      sampling::iterate(world, 1, streams, i, sample, {}, [](const sampling::StepReport&) {});
    if (world.satisfied(sample.outcome)) ++score.solutions;
  }
  score.cpu_s = thread_cpu_s() - begin_s;
  return score;
}

/// Simulates undirected throws and counts solutions.
template <class World, class Parameters, class Throw>
Score throws(const Parameters& parameters, std::uint64_t seed, std::uint64_t simulations,
             const Throw& natural) {
  Score score;
  const Counted<World> world(parameters, score.simulations);
  const double begin_s = thread_cpu_s();
  for (std::uint64_t i = 0; i < simulations; ++i) {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::prior}, i);
    if (world.satisfied(world.simulate(natural(world, stream)))) ++score.solutions;
  }
  score.cpu_s = thread_cpu_s() - begin_s;
  return score;
}

/// Whether simulations of single balls or dice are counted. The table counts simulations of single
/// dice, including those for the pools of islands. Simulations of single balls add only to the
/// core-seconds.
enum class LoneSimulations { counted, left_out };

/// Runs the starts of a search one after another. Finds are solutions, but not in the proportions
/// of p_w p_c. Returns early if the method `search` would give up. Learning the guide adds to the
/// core-seconds, not to the simulations.
template <run::StagedWorld World, class Parameters>
Score searched(const Parameters& parameters, std::uint64_t seed, std::uint64_t simulations,
               LoneSimulations lone) {
  Score score;
  const double begin_s = thread_cpu_s();
  const World world(parameters);
  const auto guide = world.learn(seed);
  const sampling::ChainStreams streams{.seed = seed, .chain = {}, .replica = {}};
  std::uint64_t in_vain = 0;
  for (std::uint64_t start = 0;
       score.simulations < simulations && in_vain < sampling::k_starts_in_vain_max; ++start) {
    sampling::SearchEffort effort;
    const bool found = run::search_start(world, guide, streams, start, effort).has_value();
    score.solutions += found ? 1 : 0;
    in_vain = found ? 0 : in_vain + 1;
    score.simulations += effort.simulations;
    if (lone == LoneSimulations::counted) score.simulations += effort.guesses;
  }
  score.cpu_s = thread_cpu_s() - begin_s;
  return score;
}

/// Runs a plan until the worker has reported `simulations` simulations.
template <class World, class Parameters>
Score carried_out(plan::Plan& plan, const Parameters& parameters,
                  const run::ChainWorkerOptions& options, std::uint64_t simulations) {
  Score score;
  const run::ChainWorker<World> worker(World(parameters), options);
  const double begin_s = thread_cpu_s();
  std::map<plan::ReplicaKey, base::Bytes> states;
  while (score.simulations < simulations) {
    const auto unit = plan.next_unit(1);
    CHECK(unit.has_value());
    base::Bytes& state = states[unit->replica];
    plan::UnitResult result = worker.run(*unit, state);
    state = std::move(result.state_after);
    score.simulations += result.simulations;
    plan.consume(unit->replica, unit->first_scan, result.scans);
  }
  score.solutions = plan.solutions_found();
  score.cpu_s = thread_cpu_s() - begin_s;
  return score;
}

template <class World>
sampling::LadderOptions ladder_for(const World& world, std::uint64_t seed) {
  sampling::LadderOptions ladder{.seed = seed,
                                 .chain = {},
                                 .first_ladder = sampling::first_ladder(12),
                                 .levels_chosen = true,
                                 .levels_max = 64,
                                 .ladder_adapts = true,
                                 .has_scale = {},
                                 .round_scans = 50};
  for (std::uint32_t kind = 0; kind < world.proposal_kinds(); ++kind)
    ladder.has_scale.push_back(world.has_scale(kind));
  return ladder;
}

enum class Method {
  parallel_tempering,
  simulated_tempering,
  tempered_transitions,
  annealed_importance
};

/// A stop rule that never holds, because the number of simulations ends the run.
inline constexpr sampling::StopRule k_no_stop{
    .scans = std::uint64_t{1} << 40U, .rounds = {}, .independent_solutions = {}};

/// Returns a plan of parallel tempering with many ladders. A ladder ends soon after its first
/// states have reached the coolest level. Temperatures are evenly spaced and don't adapt.
inline std::unique_ptr<plan::Plan> short_ladders(sampling::LadderOptions ladder,
                                                 std::uint64_t simulations) {
  constexpr std::uint32_t k_levels = 8;
  constexpr std::uint64_t k_simulations_each = 3000;
  ladder.first_ladder = sampling::first_ladder(k_levels, 1);
  ladder.levels_chosen = false;
  ladder.round_scans = k_simulations_each;  // longer than any ladder runs
  const auto ladders = static_cast<std::uint32_t>(simulations / k_simulations_each);
  return std::make_unique<sampling::ParallelTempering>(sampling::ParallelTemperingOptions{
      .ladders = std::max(1U, ladders), .ladder = ladder, .stop = k_no_stop});
}

inline std::unique_ptr<plan::Plan> plan_of(Method method, const sampling::LadderOptions& ladder) {
  if (method == Method::parallel_tempering)
    return std::make_unique<sampling::ParallelTempering>(
        sampling::ParallelTemperingOptions{.ladders = 1, .ladder = ladder, .stop = k_no_stop});
  const auto go_on =
      [method](const sampling::BurnIn& burn_in) -> std::unique_ptr<sampling::ChainPart> {
    if (method == Method::simulated_tempering)
      return std::make_unique<sampling::SimulatedTempering>(burn_in);
    if (method == Method::tempered_transitions)
      return std::make_unique<sampling::Excursions>(burn_in, 4);
    return std::make_unique<sampling::AnnealedImportance>(burn_in, 1, 10);
  };
  return std::make_unique<sampling::BurntInChains>(sampling::BurntInOptions{
      .chains = 1, .ladder = ladder, .burn_in_rounds = 3, .stop = k_no_stop, .go_on = go_on});
}

/// Number of particles per island, as in requests without a sampler.
inline constexpr std::uint32_t k_particles = 32;

/// Returns a plan of the method `sequential`, as for requests that spell short words. The plan has
/// one chain of tours. A tour has a draw only at its last scan. An unfinished tour has no solution.
inline std::unique_ptr<plan::Plan> islands(std::uint64_t seed) {
  constexpr std::uint64_t k_tour_scans = 16;
  return std::make_unique<sampling::RestartedChains>(
      sampling::RestartedChainsOptions{.seed = seed,
                                       .chains = 1,
                                       .tour_scans = k_tour_scans,
                                       .scans = k_no_stop.scans,
                                       .independent_solutions = {}});
}

/// Returns a plan of chains. Chains start from a search, and their burn-in is judged.
inline std::unique_ptr<plan::Plan> judged_chains(std::uint64_t seed,
                                                 std::vector<sampling::BurnInValue> judged) {
  return std::make_unique<sampling::JudgedChains>(
      sampling::JudgedChainsOptions{.seed = seed,
                                    .chains = 5,
                                    .round_scans = 32,
                                    .judged = std::move(judged),
                                    .scans = k_no_stop.scans,
                                    .independent_solutions = {}});
}

}  // namespace sleight::thesis
