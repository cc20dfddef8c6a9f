#include "worker/sampling/block_runner.h"

#include <optional>
#include <utility>

#include "common/base/check.h"
#include "worker/sampling/swap_flow.h"

namespace sleight::sampling {
namespace {

using plan::UnitResult;

/// Runs a unit from the given state. If none is given, uses the state that the worker holds. Empty
/// if there is neither.
std::optional<UnitResult> run_unit(const plan::UnitWorker& worker, const plan::Unit& unit,
                                   const plan::GivenState& state) {
  if (state) return worker.run(unit, *state);
  if (unit.starts) return worker.run(unit, {});
  return worker.run_from_held(unit);
}

FlowLevels levels_of(const plan::Block& block) {
  const plan::Unit& first = block.members.front();
  return {.seed = first.seed,
          .chain = first.replica.chain,
          .levels = block.ladder->levels,
          .first_level = block.ladder->first_level,
          .inverse_temperatures = block.ladder->inverse_temperatures};
}

/// A running part of a ladder. Within the part, replicas and levels are numbered from 0.
class PartRun {
 public:
  PartRun(const plan::UnitWorker& worker, const plan::Block& block)
      : worker_(worker), part_(*block.ladder), flow_(levels_of(block)) {
    for (std::uint32_t i = 0; i < block.members.size(); ++i)
      flow_.sit(i, i, block.members[i].first_scan.value);
  }

  /// Runs the members' first scans. Returns false if a member's state is neither given nor held.
  bool begin(const plan::Block& block, std::span<const plan::GivenState> states) {
    for (std::size_t i = 0; i < block.members.size(); ++i) {
      const plan::Unit& member = block.members[i];
      if (!member.starts && !states[i] && !worker_.holds(member)) return false;
    }
    for (std::size_t i = 0; i < block.members.size(); ++i) {
      std::optional<UnitResult> result = run_unit(worker_, block.members[i], states[i]);
      if (!result) return false;
      results_.push_back(*std::move(result));
    }
    scans_ = results_.size();
    for (std::uint32_t level = 0; level < flow_.size(); ++level)
      flow_.made(level, results_[level].scans.back().log_constraint);
    return true;
  }

  std::vector<UnitResult> go_on() {
    while (scans_ < part_.scans_max) {
      const std::optional<std::uint32_t> level = furthest_behind();
      if (!level) break;
      run(*level);
    }
    return std::move(results_);
  }

 private:
  /// Returns the level that runs next: the level that is furthest behind. Among several, the
  /// hottest.
  std::optional<std::uint32_t> furthest_behind() const {
    std::optional<std::uint32_t> next;
    for (std::uint32_t level = 0; level < flow_.size(); ++level) {
      const SwapFlow::Seat& seat = flow_.seat(level);
      if (!seat.may_run() || seat.scan >= part_.end_scan) continue;
      if (!next || seat.scan < flow_.seat(*next).scan) next = level;
    }
    return next;
  }

  /// Runs one more scan of the member at a level, from the member's last state.
  void run(std::uint32_t level) {
    const SwapFlow::Seat& seat = flow_.seat(level);
    UnitResult& so_far = results_[*seat.replica];
    const plan::Unit unit{.replica = so_far.unit.replica,
                          .seed = so_far.unit.seed,
                          .first_scan = base::ScanIndex{seat.scan},
                          .scans = 1,
                          .starts = false,
                          .lineage = so_far.scans.back().lineage,
                          .inverse_temperatures = {part_.inverse_temperatures[level]},
                          .proposal_scales = part_.proposal_scales[level]};
    UnitResult result = worker_.run(unit, so_far.state_after);
    so_far.scans.push_back(std::move(result.scans.front()));
    so_far.state_after = std::move(result.state_after);
    so_far.simulations += result.simulations;
    for (plan::FailedSimulation& failed : result.failed) {
      if (so_far.failed.size() == plan::k_failed_told_max) break;
      so_far.failed.push_back(std::move(failed));
    }
    ++so_far.unit.scans;
    so_far.unit.inverse_temperatures.push_back(part_.inverse_temperatures[level]);
    ++scans_;
    flow_.made(level, so_far.scans.back().log_constraint);
  }

  const plan::UnitWorker& worker_;
  const plan::LadderPart& part_;
  SwapFlow flow_;
  std::vector<UnitResult> results_;  ///< By member.
  std::uint64_t scans_ = 0;
};

}  // namespace

std::vector<UnitResult> BlockRunner::run(const plan::Block& block,
                                         std::span<const plan::GivenState> states) const {
  CHECK_EQ(block.members.size(), states.size());
  const double begin_s = clock_.now_s();
  std::vector<UnitResult> results;
  if (block.ladder) {
    PartRun part(worker_, block);
    if (part.begin(block, states)) results = part.go_on();
  } else {
    CHECK_EQ(block.members.size(), 1U);
    if (auto result = run_unit(worker_, block.members.front(), states.front()))
      results.push_back(*std::move(result));
  }
  // Divide the block's cost among its members in proportion to their scans.
  std::uint64_t scans = 0;
  for (const UnitResult& result : results)
    scans += result.unit.scans;
  const double cost_s = clock_.now_s() - begin_s;
  for (UnitResult& result : results)
    result.cost_s = cost_s * result.unit.scans / static_cast<double>(scans);
  return results;
}

}  // namespace sleight::sampling
