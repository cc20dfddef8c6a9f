// Runs free islands (worker/sampling/free_islands.h). If a run requests only the odds, it uses free
// islands.
#pragma once

#include <cstdint>
#include <utility>

#include "common/plan/unit.h"
#include "worker/run/scan_counts.h"
#include "worker/run/search_start.h"
#include "worker/sampling/island.h"
#include "worker/sampling/island_estimate.h"
#include "worker/sampling/metropolis_hastings.h"

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

/// Makes a lane's islands, one per scan. An island's random numbers depend on its number, not on
/// its lane. Island 0 reports the guide's failures. REQUIRES: unit.makes_islands(); at least 2
/// particles.
template <StagedWorld W>
plan::UnitResult island_unit(const W& world, const typename W::Guide& guide,
                             std::uint32_t particles, const plan::Unit& unit) {
  plan::UnitResult result{.unit = unit, .scans = {}, .state_after = {}};
  const auto& for_odds = guide_for_odds(world, guide);
  const sampling::ChainStreams streams{.seed = unit.seed,
                                       .chain = base::ChainId{plan::k_first_island_lane},
                                       .replica = base::ReplicaId{0}};
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    const std::uint64_t scan = unit.first_scan.value + nth;
    const std::uint64_t number = plan::island_number(unit.replica.chain, scan);
    ScanCounts counts(world.proposal_kinds());
    if (number == 0) counts.add(world.failures_of(guide));
    const auto told = [&](const sampling::SimulationReport& report) {
      ++result.simulations;
      counts.add(report);
    };
    const sampling::Islands<W> islands(world, for_odds, {.particles = particles}, streams, told);
    sampling::Island<W> island = islands.joint(number);
    const sampling::Sample<W> draw = island.drawn
                                         ? *std::move(island.drawn)
                                         : sampling::draw_afresh(world, streams, number, told);
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
    sampling::IslandEstimate{.log_z = island.log_z,
                             .log_satisfied = island.log_satisfied,
                             .effective_size = island.effective_size,
                             .accepted = island.log_z != sampling::k_log_zero}
        .append_to(record.method_values);
    result.scans.push_back(std::move(record));
  }
  return result;
}

}  // namespace sleight::run
