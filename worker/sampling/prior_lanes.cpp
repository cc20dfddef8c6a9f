#include "worker/sampling/prior_lanes.h"

namespace sleight::sampling {

WithPriorDraws::WithPriorDraws(std::unique_ptr<plan::Plan> plan, std::uint64_t draws)
    : PlanAround(std::move(plan)),
      prior_(plan::k_first_prior_lane, plan::k_prior_lanes, /*seed=*/0),
      draws_(draws) {}

template <class OfPlan, class OfPrior>
std::invoke_result_t<OfPlan> WithPriorDraws::in_turn(const OfPlan& of_plan,
                                                     const OfPrior& of_prior) {
  const bool prior_first = is_priors_turn_ && !plan().finds().is_searching();
  for (const bool is_prior : {prior_first, !prior_first}) {
    if (!is_prior && plan().finished()) continue;
    if (auto work = is_prior ? of_prior() : of_plan()) {
      is_priors_turn_ = !is_prior;
      return work;
    }
  }
  return std::nullopt;
}

std::optional<plan::Unit> WithPriorDraws::next_unit(std::uint32_t scans_max) {
  return in_turn([&] { return plan().next_unit(scans_max); },
                 [&] { return prior_.next_unit(draws_, scans_max); });
}

std::optional<plan::Block> WithPriorDraws::next_block(const plan::BlockLimits& limits) {
  return in_turn([&] { return plan().next_block(limits); },
                 [&]() -> std::optional<plan::Block> {
                   auto unit = prior_.next_unit(draws_, limits.unit_scans_max);
                   if (!unit) return std::nullopt;
                   return plan::Block{.members = {*std::move(unit)}};
                 });
}

void WithPriorDraws::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                             std::span<const plan::ScanRecord> records) {
  if (plan::is_prior_lane(replica.chain)) {
    prior_.consume(replica.chain, first_scan, records.size());
  } else {
    plan().consume(replica, first_scan, records);
  }
}

}  // namespace sleight::sampling
