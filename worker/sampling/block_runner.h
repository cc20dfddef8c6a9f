// Runs blocks (common/plan/block.h): units alone as they are, parts of ladders scan by scan with
// the swaps between their members, which flow as in the plan (swap_flow.h).
//
// Invariant: each member's records are those of its scans run one at a time at the levels at which
// the plan would have put it; a member stops where only the plan knows its next level.
// Thread-safe, if the worker is.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/clock.h"
#include "common/plan/block.h"

namespace sleight::sampling {

class BlockRunner final : public plan::BlockWorker {
 public:
  /// Borrows both; the clock measures what results say they cost.
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
