#include "worker/sampling/search_first.h"

#include <utility>

namespace sleight::sampling {

SearchFirst::SearchFirst(SearchLanes lanes, std::unique_ptr<plan::Plan> then)
    : lanes_(std::move(lanes)), then_(std::move(then)) {}

std::optional<plan::Unit> SearchFirst::next_unit(std::uint32_t scans_max) {
  if (auto unit = lanes_.next_unit(scans_max)) return unit;
  return then_ ? then_->next_unit(scans_max) : std::nullopt;
}

std::optional<plan::Block> SearchFirst::next_block(const plan::BlockLimits& limits) {
  if (auto unit = lanes_.next_unit(limits.unit_scans_max))
    return plan::Block{.members = {*std::move(unit)}, .ladder = {}};
  return then_ ? then_->next_block(limits) : std::nullopt;
}

void SearchFirst::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                          std::span<const plan::ScanRecord> records) {
  if (!then_ || lanes_.has(replica.chain)) {
    lanes_.consume(replica.chain, first_scan, records);
  } else {
    then_->consume(replica, first_scan, records);
  }
}

plan::Finds SearchFirst::finds() const {
  plan::Finds finds = lanes_.finds();
  finds.is_all = then_ == nullptr;
  return finds;
}

std::vector<plan::Solution> SearchFirst::solutions_between(std::uint64_t after,
                                                           std::uint64_t until) const {
  return then_ ? then_->solutions_between(after, until) : std::vector<plan::Solution>{};
}

std::vector<plan::EndedRound> SearchFirst::rounds_between(std::uint64_t after,
                                                          std::uint64_t until) const {
  return then_ ? then_->rounds_between(after, until) : std::vector<plan::EndedRound>{};
}

std::optional<std::uint64_t> SearchFirst::solutions_wanted() const {
  return then_ ? then_->solutions_wanted() : std::nullopt;
}

std::optional<std::uint64_t> SearchFirst::round_trips() const {
  return then_ ? then_->round_trips() : std::nullopt;
}

std::uint64_t SearchFirst::scans_consumed() const {
  return lanes_.starts() + (then_ ? then_->scans_consumed() : 0);
}

/// The number of starts that a search needs isn't known in advance.
std::optional<std::uint64_t> SearchFirst::scans_total() const {
  if (!then_) return std::nullopt;
  const auto total = then_->scans_total();
  return total ? std::optional(*total + lanes_.starts()) : std::nullopt;
}

plan::Report SearchFirst::report() const {
  return then_ ? then_->report() : plan::Report{};
}

}  // namespace sleight::sampling
