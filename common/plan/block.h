// A block is the work of one assignment: a single unit, or several neighbouring replicas of a
// ladder and the swaps between them.
//
//   scan s      . a b c d e .      a block of five levels; each member's first scan is certain
//        s+1      a b c d          e swapped with a level outside, so its next scan is unknown here
//        s+2        b c
//
// A member continues as long as the block alone determines its level. The plan decides all later
// levels. Measured cost and the set of ready units may determine which units form a block, but no
// result depends on that choice (docs/DETERMINISM). The plan verifies this: it decides each swap
// again when it consumes results (Plan::consume).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/bytes.h"
#include "common/plan/unit.h"

namespace sleight::plan {

/// The part of a ladder that a block covers.
struct LadderPart {
  std::uint32_t levels = 0;       ///< Levels of the whole ladder.
  std::uint32_t first_level = 0;  ///< First level of the part.
  /// One entry per level of the part. The members have these levels, in order. Each member starts
  /// at its own first scan.
  std::vector<double> inverse_temperatures;
  std::vector<std::vector<double>> proposal_scales;
  std::uint64_t end_scan = 0;  ///< Exclusive, at most the end of the round or run.
  /// Maximum number of scans, summed over all members. Each member always makes its first scan.
  std::uint32_t scans_max = 1;
  friend bool operator==(const LadderPart&, const LadderPart&) = default;
};

struct Block {
  std::vector<Unit> members;           ///< At least one.
  std::optional<LadderPart> ladder{};  ///< Empty: a single unit. Otherwise one scan each.
  friend bool operator==(const Block&, const Block&) = default;
};

struct BlockLimits {
  std::uint32_t unit_scans_max = 1;   ///< Scans of a single unit.
  std::uint32_t block_scans_max = 1;  ///< Scans of all members of a ladder's part together.
  /// Number of threads to keep busy. If there is at least one ladder per thread, ladders of up to
  /// whole_levels_max levels are not split, because splitting makes blocks small.
  std::uint64_t threads = 1;
  std::uint32_t whole_levels_max = 0;
};

/// A member's initial state. Empty: the worker probably holds the state, or the member has no state
/// yet.
using GivenState = std::optional<base::Bytes>;

/// Computes blocks. Thread-safe: run may be called from several threads at once.
class BlockWorker {
 public:
  virtual ~BlockWorker() = default;
  /// Returns one result per member, in order. Each result has at least one scan. If a state is
  /// neither given nor held, returns no results. REQUIRES: one entry of `states` per member.
  virtual std::vector<UnitResult> run(const Block& block,
                                      std::span<const GivenState> states) const = 0;
  virtual CacheUse cache_use() const = 0;
};

}  // namespace sleight::plan
