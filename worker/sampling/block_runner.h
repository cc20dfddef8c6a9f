// Runs blocks (common/plan/block.h). A block is a unit or a part of a ladder. In a part of a
// ladder, scans run one at a time, and members swap (swap_flow.h).
// Invariant: a member's records are the same if its scans run one at a time, at the levels that the
// plan would choose. A member stops where only the plan can determine its next level. Thread-safe
// if the worker is.
#pragma once

#include <span>
#include <vector>

#include "common/base/clock.h"
#include "common/plan/block.h"

namespace sleight::sampling {

class BlockRunner final : public plan::BlockWorker {
 public:
  /// Borrows both arguments. The clock measures the cost that results report.
  BlockRunner(const plan::UnitWorker& worker, const base::Clock& clock)
      : worker_(worker), clock_(clock) {}

  std::vector<plan::UnitResult> run(const plan::Block& block,
                                    std::span<const plan::GivenState> states) const override;
  plan::CacheUse cache_use() const override { return worker_.cache_use(); }

 private:
  const plan::UnitWorker& worker_;
  const base::Clock& clock_;
};

}  // namespace sleight::sampling
