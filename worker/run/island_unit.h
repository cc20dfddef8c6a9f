// Runs free islands (worker/sampling/free_islands.h). If a run requests only the odds, it uses free
// islands: of a world that acts in stages, or within the levels of a world that judges in stages.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/plan/unit.h"
#include "worker/run/scan_counts.h"
#include "worker/run/search_start.h"
#include "worker/sampling/island.h"
#include "worker/sampling/island_estimate.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/particle_steps.h"
#include "worker/sampling/splitting.h"

namespace sleight::run {

/// Returns the guide for islands that only estimate the odds, so that no chain continues from their
/// draws. The result is a value or a reference.
template <StagedWorld W>
decltype(auto) guide_for_odds(const W& world, const typename W::Guide& guide) {
  if constexpr (sampling::ListsChoices<W>) {
    return world.for_odds(guide);
  } else {
    return (guide);
  }
}

/// An island's random numbers depend on its number, not on its lane. Extinct islands add a prior
/// draw from replica 0; islands with levels use replica 1, and the search for levels uses
/// replica 2.
inline sampling::ChainStreams island_streams(std::uint64_t seed, std::uint32_t replica) {
  return {.seed = seed,
          .chain = base::ChainId{plan::k_first_island_lane},
          .replica = base::ReplicaId{replica}};
}

/// Counts the steps and simulations that are told to it.
class CountsTold {
 public:
  CountsTold(ScanCounts& counts, std::uint64_t& simulations)
      : counts_(counts), simulations_(simulations) {}
  void operator()(const sampling::SimulationReport& report) const {
    ++simulations_;
    counts_.add(report);
  }
  void operator()(const sampling::StepReport& step) const {
    if (step.simulated) ++simulations_;
    counts_.add(step);
  }

 private:
  ScanCounts& counts_;
  std::uint64_t& simulations_;
};

/// Makes a lane's islands, one per scan. `make(number, counts, told)` returns an island's estimate
/// and, unless it is extinct, its draw. REQUIRES: unit.makes_islands().
template <sampling::Target W, class Make>
plan::UnitResult island_unit(const W& world, const plan::Unit& unit, const Make& make) {
  plan::UnitResult result{.unit = unit, .scans = {}, .state_after = {}};
  const sampling::ChainStreams streams = island_streams(unit.seed, 0);
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    const std::uint64_t scan = unit.first_scan.value + nth;
    const std::uint64_t number = plan::island_number(unit.replica.chain, scan);
    ScanCounts counts(world.proposal_kinds());
    const CountsTold told(counts, result.simulations);
    auto [estimate, drawn] = make(number, counts, told);
    const sampling::Sample<W> draw =
        drawn ? *std::move(drawn) : sampling::draw_afresh(world, streams, number, told);
    counts.tell_failed(scan, result.failed);
    plan::ScanRecord record{.log_prior = draw.log_prior,
                            .log_constraint = draw.log_constraint,
                            .satisfied = world.satisfied(draw.outcome),
                            .lineage = plan::lineage_from(streams.replica, number),
                            .proposed = std::move(counts.proposed),
                            .accepted = std::move(counts.accepted),
                            .outcome = world.outcome_values(draw.outcome),
                            .failures = counts.failures,
                            .overlapping_starts = counts.overlapping_starts,
                            .state = world.encode(draw.state)};
    estimate.append_to(record.method_values);
    result.scans.push_back(std::move(record));
  }
  return result;
}

/// Islands of a world that acts in stages. Island 0 reports the guide's failures. REQUIRES: at
/// least 2 particles.
template <StagedWorld W>
plan::UnitResult staged_islands(const W& world, const typename W::Guide& guide,
                                std::uint32_t particles, const plan::Unit& unit) {
  const auto& for_odds = guide_for_odds(world, guide);
  const sampling::ChainStreams streams = island_streams(unit.seed, 0);
  return island_unit(world, unit,
                     [&](std::uint64_t number, ScanCounts& counts, const CountsTold& told) {
                       if (number == 0) counts.add(world.failures_of(guide));
                       const sampling::Islands<W> islands(world, for_odds, {.particles = particles},
                                                          streams, told);
                       sampling::Island<W> island = islands.joint(number);
                       sampling::IslandEstimate estimate = sampling::estimate_of(island);
                       estimate.accepted = island.log_z != sampling::k_log_zero;
                       return std::pair(estimate, std::move(island.drawn));
                     });
}

/// The levels of a run, with the work that found them.
struct FoundLevels {
  std::vector<sampling::Level> levels;
  ScanCounts counts;
  std::uint64_t simulations = 0;
};

template <sampling::PassesStages W>
FoundLevels find_levels(const W& world, std::uint32_t particles, std::uint64_t seed) {
  FoundLevels found{.levels = {}, .counts = ScanCounts(world.proposal_kinds())};
  const sampling::Splitting<W> splitting(world, particles, island_streams(seed, 2));
  found.levels = splitting.find_levels(CountsTold(found.counts, found.simulations));
  return found;
}

/// Islands within levels. Island 0 reports the work that found them.
template <sampling::PassesStages W>
plan::UnitResult split_islands(const W& world, const FoundLevels& found, std::uint32_t particles,
                               const plan::Unit& unit) {
  const sampling::Splitting<W> splitting(world, particles, island_streams(unit.seed, 1));
  std::uint64_t for_levels = 0;
  plan::UnitResult result = island_unit(
      world, unit, [&](std::uint64_t number, ScanCounts& counts, const CountsTold& told) {
        if (number == 0) {
          counts = found.counts;
          for_levels = found.simulations;
        }
        sampling::SplitIsland<W> island = splitting.island(found.levels, number, told);
        return std::pair(island.estimate, std::move(island.drawn));
      });
  result.simulations += for_levels;
  return result;
}

}  // namespace sleight::run
