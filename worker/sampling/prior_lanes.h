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
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/numbered_lanes.h"

namespace sleight::sampling {

class WithPriorDraws final : public plan::Plan {
 public:
  WithPriorDraws(std::unique_ptr<plan::Plan> plan, std::uint64_t draws);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  std::optional<plan::Block> next_block(const plan::BlockLimits& limits) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return plan_->finished() && is_drawn(); }
  std::uint64_t prior_draws() const override { return std::min(prior_.done(), draws_); }
  std::uint64_t prior_draws_wanted() const override { return draws_; }
  std::uint64_t scans_consumed() const override { return plan_->scans_consumed(); }
  std::optional<std::uint64_t> scans_total() const override { return plan_->scans_total(); }

  base::BytesView start_state(plan::ReplicaKey replica) const override {
    return plan_->start_state(replica);
  }
  std::uint64_t scans_common() const override { return plan_->scans_common(); }
  plan::Draws draws() const override { return plan_->draws(); }
  std::uint64_t solutions_found() const override { return plan_->solutions_found(); }
  std::optional<std::uint64_t> solutions_wanted() const override {
    return plan_->solutions_wanted();
  }
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override {
    return plan_->solutions_between(after, until);
  }
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override {
    return plan_->rounds_between(after, until);
  }
  plan::Finds finds() const override { return plan_->finds(); }
  std::uint64_t starts_done() const override { return plan_->starts_done(); }
  std::vector<plan::Find> finds_between(std::uint64_t first, std::uint64_t end) const override {
    return plan_->finds_between(first, end);
  }
  plan::Odds odds() const override { return plan_->odds(); }
  std::optional<std::uint64_t> round_trips() const override { return plan_->round_trips(); }
  plan::Report report() const override { return plan_->report(); }
  bool learns() const override { return plan_->learns(); }

 private:
  bool is_drawn() const { return prior_.done() >= draws_; }
  /// Returns the plan's next work or the prior's next work. The two alternate.
  template <class OfPlan, class OfPrior>
  std::invoke_result_t<OfPlan> in_turn(const OfPlan& of_plan, const OfPrior& of_prior);

  std::unique_ptr<plan::Plan> plan_;
  NumberedLanes prior_;
  std::uint64_t draws_;
  bool is_priors_turn_ = false;
};

}  // namespace sleight::sampling
