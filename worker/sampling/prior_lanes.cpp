#include "worker/sampling/prior_lanes.h"

#include <algorithm>

#include "common/base/check.h"

namespace sleight::sampling {

using plan::k_prior_lanes;

PriorLanes::PriorLanes(std::uint64_t count) : count_(count), scans_(k_prior_lanes, 0) {
  for (std::uint32_t lane = 0; lane < k_prior_lanes; ++lane)
    idle_.emplace(0, lane);
}

/// Of all draws, those in a lane.
std::uint64_t PriorLanes::scans_of(std::uint32_t lane) const {
  return (count_ + k_prior_lanes - 1 - lane) / k_prior_lanes;
}

std::optional<plan::Unit> PriorLanes::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  if (idle_.empty()) return std::nullopt;
  const auto [scan, id] = *idle_.begin();
  // The least number is first: where that is not asked for, none is.
  if (scan >= scans_of(id)) return std::nullopt;
  idle_.erase(idle_.begin());
  const std::uint64_t scans = std::min<std::uint64_t>(scans_of(id) - scan, scans_max);
  return plan::Unit{.replica = {base::ChainId{plan::k_first_prior_lane + id}, base::ReplicaId{0}},
                    .first_scan = base::ScanIndex{scan},
                    .scans = static_cast<std::uint32_t>(scans),
                    .starts = true};
}

void PriorLanes::consume(base::ChainId lane, base::ScanIndex first_scan, std::size_t records) {
  const std::uint32_t id = lane.value - plan::k_first_prior_lane;
  CHECK_LT(id, k_prior_lanes);
  CHECK_EQ(first_scan.value, scans_[id]);
  idle_.erase({scans_[id], id});  // there when it comes from a run store
  scans_[id] += records;
  idle_.emplace(scans_[id], id);
  while (done_ < count_ && done_ / k_prior_lanes < scans_[done_ % k_prior_lanes])
    ++done_;
}

WithPriorDraws::WithPriorDraws(std::unique_ptr<plan::Plan> plan, std::uint64_t draws)
    : plan_(std::move(plan)), prior_(draws) {}

template <class OfPlan, class OfPrior>
std::invoke_result_t<OfPlan> WithPriorDraws::in_turn(const OfPlan& of_plan,
                                                     const OfPrior& of_prior) {
  const bool prior_first = is_priors_turn_ && !plan_->finds().is_searching();
  for (const bool is_prior : {prior_first, !prior_first}) {
    if (!is_prior && plan_->finished()) continue;
    if (auto work = is_prior ? of_prior() : of_plan()) {
      is_priors_turn_ = !is_prior;
      return work;
    }
  }
  return std::nullopt;
}

std::optional<plan::Unit> WithPriorDraws::next_unit(std::uint32_t scans_max) {
  return in_turn([&] { return plan_->next_unit(scans_max); },
                 [&] { return prior_.next_unit(scans_max); });
}

std::optional<plan::Block> WithPriorDraws::next_block(const plan::BlockLimits& limits) {
  return in_turn([&] { return plan_->next_block(limits); },
                 [&]() -> std::optional<plan::Block> {
                   auto unit = prior_.next_unit(limits.unit_scans_max);
                   if (!unit) return std::nullopt;
                   return plan::Block{.members = {*std::move(unit)}, .ladder = {}};
                 });
}

void WithPriorDraws::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                             std::span<const plan::ScanRecord> records) {
  if (plan::is_prior_lane(replica.chain)) {
    prior_.consume(replica.chain, first_scan, records.size());
  } else {
    plan_->consume(replica, first_scan, records);
  }
}

}  // namespace sleight::sampling
