#include "worker/sampling/block_runner.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/base/check.h"
#include "worker/sampling/swap.h"

namespace sleight::sampling {
namespace {

using plan::UnitResult;

/// A unit from the state that is given, or from what the worker holds; none if it has neither.
std::optional<UnitResult> run_unit(const plan::UnitWorker& worker, const plan::Unit& unit,
                                   const plan::GivenState& state) {
  if (unit.starts) return worker.run(unit, {});
  if (state) return worker.run(unit, *state);
  return worker.run_from_held(unit);
}

/// A part of a ladder on its way. Levels are counted from the part's first.
class PartRun {
 public:
  PartRun(const plan::UnitWorker& worker, const plan::Block& block)
      : worker_(worker),
        part_(*block.ladder),
        seats_(block.members.size()),
        results_(block.members.size()) {
    for (std::size_t i = 0; i < seats_.size(); ++i)
      seats_[i] = {.member = i, .scan = block.members[i].first_scan.value};
  }

  /// False when a state is neither given nor held: then nothing is run, as far as that is known
  /// before.
  bool begin(const plan::Block& block, std::span<const plan::GivenState> states) {
    for (std::size_t i = 0; i < seats_.size(); ++i) {
      const plan::Unit& member = block.members[i];
      if (!member.starts && !states[i] && !worker_.holds(member)) return false;
    }
    for (std::size_t i = 0; i < seats_.size(); ++i) {
      std::optional<UnitResult> result = run_unit(worker_, block.members[i], states[i]);
      if (!result) return false;
      results_[i] = *std::move(result);
      ++scans_;
    }
    // All have made their first scans; swaps follow from these.
    for (std::size_t level = 0; level < seats_.size(); ++level) {
      seats_[level].done = true;
    }
    for (std::size_t level = 0; level < seats_.size(); ++level)
      follow(level);
    return true;
  }

  std::vector<UnitResult> go_on() {
    while (scans_ < part_.scans_max) {
      // The seat furthest behind, the hottest among equals.
      std::size_t next = seats_.size();
      for (std::size_t level = 0; level < seats_.size(); ++level) {
        if (!may_run(seats_[level])) continue;
        if (next == seats_.size() || seats_[level].scan < seats_[next].scan) next = level;
      }
      if (next == seats_.size()) break;
      run(next);
      follow(next);
    }
    return std::move(results_);
  }

 private:
  /// Who is at a level, and at which scan; nobody once the next one's level isn't known here.
  struct Seat {
    std::optional<std::size_t> member;
    std::uint64_t scan = 0;
    bool done = false;  ///< the scan; the swap after it waits for the partner
  };

  bool may_run(const Seat& seat) const {
    return seat.member && !seat.done && seat.scan < part_.end_scan;
  }

  /// One more scan of the member at a level, from its own state after the last.
  void run(std::size_t level) {
    Seat& seat = seats_[level];
    UnitResult& so_far = results_[*seat.member];
    const plan::Unit unit{.replica = so_far.unit.replica,
                          .seed = so_far.unit.seed,
                          .first_scan = base::ScanIndex{seat.scan},
                          .scans = 1,
                          .starts = false,
                          .lineage = so_far.scans.back().lineage,
                          .inverse_temperatures = {part_.inverse_temperatures[level]},
                          .proposal_scales = part_.proposal_scales[level],
                          .excursion = {}};
    UnitResult result = worker_.run(unit, so_far.state_after);
    so_far.scans.push_back(std::move(result.scans.front()));
    so_far.state_after = std::move(result.state_after);
    so_far.simulations += result.simulations;
    ++so_far.unit.scans;
    so_far.unit.inverse_temperatures.push_back(part_.inverse_temperatures[level]);
    seat.done = true;
    ++scans_;
  }

  /// What follows from a scan that is done: who is where next, as far as the part can tell.
  void follow(std::size_t level) {
    Seat& seat = seats_[level];
    if (!seat.member || !seat.done) return;
    const std::uint32_t of_ladder = part_.first_level + static_cast<std::uint32_t>(level);
    const std::optional<std::uint32_t> partner =
        even_odd_partner(of_ladder, seat.scan, part_.levels);
    if (!partner) {
      seat = {.member = seat.member, .scan = seat.scan + 1};
      return;
    }
    const bool outside =
        *partner < part_.first_level || *partner >= part_.first_level + seats_.size();
    if (outside) {
      seat.member.reset();
      return;
    }
    Seat& other = seats_[*partner - part_.first_level];
    if (!other.member || !other.done || other.scan != seat.scan) return;
    const bool is_hotter = *partner > of_ladder;
    swap(is_hotter ? level : *partner - part_.first_level);
  }

  /// The two at a level and the next cooler one go on, each at its own or at the other's.
  void swap(std::size_t hotter_level) {
    Seat& hotter = seats_[hotter_level];
    Seat& cooler = seats_[hotter_level + 1];
    const auto log_constraint = [&](const Seat& seat) {
      return results_[*seat.member].scans.back().log_constraint;
    };
    const bool swapped =
        swaps({.seed = results_[*hotter.member].unit.seed,
               .chain = results_[*hotter.member].unit.replica.chain,
               .level = part_.first_level + static_cast<std::uint32_t>(hotter_level),
               .scan = hotter.scan},
              {.hotter = part_.inverse_temperatures[hotter_level],
               .cooler = part_.inverse_temperatures[hotter_level + 1],
               .log_constraint_hotter = log_constraint(hotter),
               .log_constraint_cooler = log_constraint(cooler)});
    if (swapped) std::swap(hotter.member, cooler.member);
    for (Seat* seat : {&hotter, &cooler})
      *seat = {.member = seat->member, .scan = seat->scan + 1};
  }

  const plan::UnitWorker& worker_;
  const plan::LadderPart& part_;
  std::vector<Seat> seats_;  ///< by level
  std::vector<UnitResult> results_;
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
  // What the block cost, shared out by scans.
  std::uint64_t scans = 0;
  for (const UnitResult& result : results)
    scans += result.unit.scans;
  const double cost_s = clock_.now_s() - begin_s;
  for (UnitResult& result : results)
    result.cost_s = cost_s * result.unit.scans / static_cast<double>(scans);
  return results;
}

}  // namespace sleight::sampling
