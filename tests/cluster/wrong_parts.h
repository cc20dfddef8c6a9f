// Implements each mistake of mistakes.h in a coordinator or worker. Correct coordinators and
// workers use none of this code.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/plan/block.h"
#include "common/schema/messages.h"
#include "tests/cluster/mistakes.h"
#include "tests/unit/worker/sampling/replaced_formulas.h"

namespace sleight::cluster {

/// Handles deliveries as a wrong coordinator does. Not thread-safe.
class WrongDeliveries {
 public:
  WrongDeliveries(Mistake mistake, std::uint64_t epoch) : mistake_(mistake), epoch_(epoch) {}
  void given(const schema::Assignment& assignment);
  /// Replaces the delivery by the one that the wrong coordinator believes it received.
  void take(schema::Delivery& delivery);

 private:
  bool take_as(schema::Delivery& delivery, std::uint64_t assignment) const;

  Mistake mistake_;
  std::uint64_t epoch_;
  std::map<std::uint64_t, plan::Block> outstanding_;  ///< by assignment
  std::map<std::uint64_t, plan::Block> delivered_;
};

/// Makes a block worker handle parts of ladders wrongly. Borrows both workers. Thread-safe if they
/// are.
class WrongBlocks final : public plan::BlockWorker {
 public:
  WrongBlocks(Mistake mistake, const plan::BlockWorker& right, const plan::UnitWorker& units)
      : mistake_(mistake), right_(right), units_(units) {}
  std::vector<plan::UnitResult> run(const plan::Block& block,
                                    std::span<const plan::GivenState> states) const override;
  plan::CacheUse cache_use() const override { return right_.cache_use(); }

 private:
  Mistake mistake_;
  const plan::BlockWorker& right_;
  const plan::UnitWorker& units_;
};

/// The plan's formulas for decisions.
sampling::Formulas formulas_with(Mistake mistake);

}  // namespace sleight::cluster
