// Outgoing work of LadderRun, divided into units and blocks. No result depends on this division.
#include <algorithm>
#include <cmath>

#include "worker/sampling/ladder.h"
#include "worker/sampling/ladder_run.h"

namespace sleight::sampling {

bool LadderRun::may_run(std::uint32_t id, std::uint64_t horizon) const {
  const Replica& replica = replicas_[id];
  const bool anneals = replica.lives && replica.next_scan < options_.anneal_scans;
  if (replica.level == k_nobody && !anneals) return false;
  return !replica.handed_out && replica.next_scan < horizon;
}

/// Returns the runnable replica that is furthest behind; among several, the lowest id. If no
/// replica can run, returns k_nobody.
std::uint32_t LadderRun::furthest_behind(std::uint64_t horizon) const {
  std::uint32_t chosen = k_nobody;
  for (std::uint32_t id = 0; id < replicas_.size(); ++id) {
    if (!may_run(id, horizon)) continue;
    if (chosen == k_nobody || replicas_[id].next_scan < replicas_[chosen].next_scan) chosen = id;
  }
  return chosen;
}

/// Returns a unit that anneals the replica from the prior to its first temperature.
plan::Unit LadderRun::anneal(std::uint32_t id, std::uint32_t scans_max) const {
  const Replica& replica = replicas_[id];
  const std::uint64_t scans =
      std::min<std::uint64_t>(options_.anneal_scans - replica.next_scan, scans_max);
  return {.replica = {options_.chain, base::ReplicaId{id}},
          .seed = options_.seed,
          .first_scan = base::ScanIndex{replica.next_scan},
          .scans = static_cast<std::uint32_t>(scans),
          .starts = replica.next_scan == 0,
          .lineage = replica.lineage,
          .inverse_temperatures = annealing(options_.first_ladder[id], options_.anneal_scans,
                                            replica.next_scan, scans)};
}

/// Returns a replica's next scan. REQUIRES: the replica's level is known.
plan::Unit LadderRun::scan_of(std::uint32_t id) const {
  const Replica& replica = replicas_[id];
  return {.replica = {options_.chain, base::ReplicaId{id}},
          .seed = options_.seed,
          .first_scan = base::ScanIndex{replica.next_scan},
          .scans = 1,
          .starts = replica.next_scan == replica.first_scan,
          .lineage = replica.lineage,
          .inverse_temperatures = {ladder()[replica.level]},
          .proposal_scales = rounds_.back().scales[replica.level]};
}

std::optional<plan::Unit> LadderRun::next_unit(std::uint64_t horizon, std::uint32_t scans_max) {
  const std::uint32_t chosen = furthest_behind(horizon);
  if (chosen == k_nobody) return std::nullopt;
  Replica& replica = replicas_[chosen];
  replica.handed_out = true;
  if (replica.next_scan >= options_.anneal_scans) return scan_of(chosen);
  const std::uint64_t left = horizon - replica.next_scan;
  return anneal(chosen, static_cast<std::uint32_t>(std::min<std::uint64_t>(left, scans_max)));
}

/// Returns the scan at which a block of the whole ladder ends. All its levels end at this scan, so
/// they can continue together. The block has as many rows as the limit allows, but at least one new
/// row.
std::uint64_t LadderRun::whole_rows_end(std::span<const std::uint32_t> ready,
                                        std::uint64_t end_scan, std::uint64_t scans_max) const {
  std::uint64_t begin = 0;  // First row that no level has begun.
  std::uint64_t sum = 0;
  for (const std::uint32_t id : ready) {
    begin = std::max(begin, replicas_[id].next_scan);
    sum += replicas_[id].next_scan;
  }
  const std::uint64_t most = (scans_max + sum) / ready.size();
  return std::min(end_scan, std::max(begin + 1, most));
}

/// Returns the runnable replica at each level, or k_nobody if that level has no such replica.
std::vector<std::uint32_t> LadderRun::ready_by_level(std::uint64_t horizon) const {
  std::vector<std::uint32_t> ready(levels(), k_nobody);
  for (std::uint32_t id = 0; id < replicas_.size(); ++id) {
    if (replicas_[id].level != k_nobody && may_run(id, horizon)) ready[replicas_[id].level] = id;
  }
  return ready;
}

/// Returns a stretch of at most `wanted` levels. The stretch begins as `level`; then ready
/// neighbours are added, alternating between both sides.
LadderRun::Stretch LadderRun::joined(std::span<const std::uint32_t> ready, std::uint32_t level,
                                     std::uint64_t wanted) {
  Stretch stretch{.first = level, .end = level + 1};
  for (bool grew = true; grew && stretch.size() < wanted;) {
    grew = stretch.end < ready.size() && ready[stretch.end] != k_nobody;
    if (grew) ++stretch.end;
    if (stretch.size() < wanted && stretch.first > 0 && ready[stretch.first - 1] != k_nobody) {
      --stretch.first;
      grew = true;
    }
  }
  return stretch;
}

std::optional<plan::Block> LadderRun::next_block(std::uint64_t horizon,
                                                 const plan::BlockLimits& limits,
                                                 std::size_t ladders) {
  const std::uint32_t chosen = furthest_behind(horizon);
  if (chosen == k_nobody) return std::nullopt;
  const bool alone =
      limits.block_scans_max <= 1 || replicas_[chosen].next_scan < options_.anneal_scans;
  if (alone) {
    return plan::Block{.members = {*next_unit(horizon, limits.unit_scans_max)}};
  }

  // An undivided ladder waits until all its levels can run.
  const std::vector<std::uint32_t> ready = ready_by_level(horizon);
  const bool is_whole = std::ranges::find(ready, k_nobody) == ready.end();
  const bool waits_for_all = ladders >= limits.threads && levels() <= limits.whole_levels_max;
  if (waits_for_all && !is_whole && std::ranges::any_of(replicas_, &Replica::handed_out))
    return std::nullopt;

  // Add neighbours. Take the whole ladder if the limit allows a scan of each level. Otherwise the
  // scans form a triangle: each further scan has one level fewer on each side. Take as many levels
  // as fit.
  const auto root = static_cast<std::uint64_t>(std::sqrt(2.0 * limits.block_scans_max));
  const std::uint64_t share =
      ladders >= limits.threads ? levels() : ladders * levels() / (2 * limits.threads);
  const bool has_scans_for_all = limits.block_scans_max >= levels();
  const bool takes_all = waits_for_all || (has_scans_for_all && share == levels());
  const std::uint64_t wanted =
      takes_all ? levels() : std::min(share, has_scans_for_all ? levels() : root);
  const Stretch stretch = joined(ready, replicas_[chosen].level, wanted);

  plan::Block block =
      block_of(ready, stretch,
               {.end_scan = std::min(horizon, round_end()), .scans_max = limits.block_scans_max});
  plan::LadderPart& part = *block.ladder;
  if (is_whole && takes_all) {
    const std::uint64_t end_scan = whole_rows_end(ready, part.end_scan, limits.block_scans_max);
    std::uint64_t scans = 0;
    for (const std::uint32_t id : ready)
      scans += end_scan - replicas_[id].next_scan;
    if (waits_for_all || scans <= limits.block_scans_max) {
      part.end_scan = end_scan;
      part.scans_max = static_cast<std::uint32_t>(scans);
    }
  }
  return block;
}

/// Hands out the scans of the ready replicas whose levels are in the stretch.
plan::Block LadderRun::block_of(std::span<const std::uint32_t> ready, const Stretch& stretch,
                                const BlockEnd& end) {
  plan::Block block;
  plan::LadderPart& part = block.ladder.emplace();
  part = {.levels = levels(),
          .first_level = stretch.first,
          .inverse_temperatures = {},
          .proposal_scales = {},
          .end_scan = end.end_scan,
          .scans_max = end.scans_max};
  for (std::uint32_t level = stretch.first; level < stretch.end; ++level) {
    block.members.push_back(scan_of(ready[level]));
    replicas_[ready[level]].handed_out = true;
    part.inverse_temperatures.push_back(ladder()[level]);
    part.proposal_scales.push_back(rounds_.back().scales[level]);
  }
  return block;
}

}  // namespace sleight::sampling
