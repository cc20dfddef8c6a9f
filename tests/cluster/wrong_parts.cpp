#include "tests/cluster/wrong_parts.h"

#include <algorithm>
#include <utility>

namespace sleight::cluster {
namespace {

/// Returns a swap's number in the order of decisions.
double number_of_next_swap(const sampling::SwapPlace& place) {
  static std::uint64_t swaps = 0;
  sampling::SwapPlace next = place;
  next.scan = swaps++;
  return sampling::right_swap_number(next);
}

}  // namespace

void WrongDeliveries::given(const schema::Assignment& assignment) {
  if (mistake_ != Mistake::none) outstanding_[assignment.assignment] = assignment.block;
}

/// Gives the results the names of another assignment's results. Returns false if the assignments
/// differ in more than names.
bool WrongDeliveries::take_as(schema::Delivery& delivery, std::uint64_t assignment) const {
  const plan::Block& asked = outstanding_.at(assignment);
  if (asked.ladder || asked.members.size() != delivery.results.size()) return false;
  plan::UnitResult& result = delivery.results.front();
  const plan::Unit& unit = asked.members.front();
  if (unit.scans != result.unit.scans) return false;
  delivery.epoch = epoch_;
  delivery.assignment = assignment;
  result.unit.replica = unit.replica;
  result.unit.first_scan = unit.first_scan;
  return true;
}

void WrongDeliveries::take(schema::Delivery& delivery) {
  if (mistake_ == Mistake::none || delivery.results.empty()) return;
  const std::uint64_t number = delivery.assignment;
  if (mistake_ == Mistake::stale_epoch && delivery.epoch != epoch_) {
    if (outstanding_.contains(number)) take_as(delivery, number);
    return;
  }
  if (delivery.epoch != epoch_) return;
  if (mistake_ == Mistake::completion_order && !outstanding_.empty())
    take_as(delivery, outstanding_.begin()->first);
  if (mistake_ == Mistake::doubled_goes_on && delivered_.contains(number)) {
    const plan::ReplicaKey replica = delivered_.at(number).members.front().replica;
    for (const auto& [id, block] : outstanding_) {
      if (block.members.front().replica == replica && take_as(delivery, id)) break;
    }
  }
  auto done = outstanding_.extract(delivery.assignment);
  if (!done.empty()) delivered_.insert(std::move(done));
}

std::vector<plan::UnitResult> WrongBlocks::run(const plan::Block& block,
                                               std::span<const plan::GivenState> states) const {
  std::vector<plan::UnitResult> results = right_.run(block, states);
  if (results.size() < 2) return results;
  if (mistake_ == Mistake::double_swap) std::swap(results[0].state_after, results[1].state_after);
  if (mistake_ == Mistake::past_the_edge) {
    plan::UnitResult& last = results.back();
    plan::Unit more = last.unit;
    more.first_scan.value += more.scans;
    if (more.first_scan.value >= block.ladder->end_scan) return results;
    more.scans = 1;
    more.starts = false;
    more.lineage = last.scans.back().lineage;
    more.inverse_temperatures = {last.scans.back().inverse_temperature};
    more.proposal_scales = block.ladder->proposal_scales.back();
    plan::UnitResult one = units_.run(more, last.state_after);
    last.scans.push_back(std::move(one.scans.front()));
    last.state_after = std::move(one.state_after);
    ++last.unit.scans;
  }
  return results;
}

sampling::Formulas formulas_with(Mistake mistake) {
  sampling::Formulas formulas;
  if (mistake == Mistake::swaps_in_any_order) formulas.swap_number = number_of_next_swap;
  return formulas;
}

}  // namespace sleight::cluster
