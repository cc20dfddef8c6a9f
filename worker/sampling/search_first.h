// A search, and an optional plan after it. So people see examples before the first draws in the
// model's proportions. Not thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "worker/sampling/plan_around.h"
#include "worker/sampling/search_lanes.h"

namespace sleight::sampling {

class SearchFirst final : public PlanAround {
 public:
  /// If `then` is null, only the search runs.
  SearchFirst(SearchLanes lanes, std::unique_ptr<plan::Plan> then);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  std::optional<plan::Block> next_block(const plan::BlockLimits& limits) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return lanes_.finished() && plan().finished(); }
  plan::Finds finds() const override;
  std::uint64_t starts_done() const override { return lanes_.starts_done(); }
  std::vector<plan::Find> finds_between(std::uint64_t first, std::uint64_t end) const override {
    return lanes_.finds_between(first, end);
  }
  std::uint64_t scans_consumed() const override;
  std::optional<std::uint64_t> scans_total() const override;

 private:
  SearchLanes lanes_;
};

}  // namespace sleight::sampling
