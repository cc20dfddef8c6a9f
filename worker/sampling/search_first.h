// A search, and an optional plan after it. So people see examples before the first draws in the
// model's proportions. Not thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/search_lanes.h"

namespace sleight::sampling {

class SearchFirst final : public plan::Plan {
 public:
  /// If `then` is null, only the search runs.
  SearchFirst(SearchLanes lanes, std::unique_ptr<plan::Plan> then);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  std::optional<plan::Block> next_block(const plan::BlockLimits& limits) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return lanes_.finished() && (!then_ || then_->finished()); }
  std::uint64_t scans_common() const override { return then_ ? then_->scans_common() : 0; }
  plan::Draws draws() const override { return then_ ? then_->draws() : plan::Draws{}; }
  std::uint64_t solutions_found() const override { return then_ ? then_->solutions_found() : 0; }
  std::optional<std::uint64_t> solutions_wanted() const override;
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override;
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override;
  plan::Finds finds() const override;
  std::uint64_t starts_done() const override { return lanes_.starts_done(); }
  std::vector<plan::Find> finds_between(std::uint64_t first, std::uint64_t end) const override {
    return lanes_.finds_between(first, end);
  }
  plan::Odds odds() const override { return then_ ? then_->odds() : plan::Odds{}; }
  std::optional<std::uint64_t> round_trips() const override;
  std::uint64_t scans_consumed() const override;
  std::optional<std::uint64_t> scans_total() const override;
  plan::Report report() const override;
  bool learns() const override { return then_ && then_->learns(); }

 private:
  SearchLanes lanes_;
  std::unique_ptr<plan::Plan> then_;
};

}  // namespace sleight::sampling
