// Adds prior draws to a plan. Archives store these draws beside a run's samples. Draws are numbered
// over lanes (plan::k_prior_lanes, numbered_lanes.h). While the plan searches, prior draws only
// fill idle time. After the search, the plan's units and prior draws alternate. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>

#include "worker/sampling/numbered_lanes.h"
#include "worker/sampling/plan_around.h"

namespace sleight::sampling {

class WithPriorDraws final : public PlanAround {
 public:
  WithPriorDraws(std::unique_ptr<plan::Plan> plan, std::uint64_t draws);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  std::optional<plan::Block> next_block(const plan::BlockLimits& limits) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return plan().finished() && is_drawn(); }
  std::uint64_t prior_draws() const override { return std::min(prior_.done(), draws_); }
  std::uint64_t prior_draws_wanted() const override { return draws_; }

 private:
  bool is_drawn() const { return prior_.done() >= draws_; }
  /// Returns the plan's next work or the prior's next work. The two alternate.
  template <class OfPlan, class OfPrior>
  std::invoke_result_t<OfPlan> in_turn(const OfPlan& of_plan, const OfPrior& of_prior);

  NumberedLanes prior_;
  std::uint64_t draws_;
  bool is_priors_turn_ = false;
};

}  // namespace sleight::sampling
