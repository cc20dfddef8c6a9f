// What one worker is given at a time: a unit alone, or units of neighbouring replicas of a ladder
// with the swaps between them.
//
//   scan s      . a b c d e .      a block of five levels; each member's first scan is certain
//        s+1      a b c d          e swapped with a level outside: what comes next is not known
//        here s+2        b c
//
// A member goes on as long as the block itself decides at which level; what it can't decide is left
// to the plan. So how far each member comes hangs on the swaps. Which units are in one block may
// follow measured cost, or what happens to be ready: results do not depend on it
// (docs/DETERMINISM), and the plan, which decides each swap again when it consumes them, checks
// that (Plan::consume).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/bytes.h"
#include "common/plan/unit.h"

namespace sleight::plan {

/// The part of a ladder that a block's members are at.
struct LadderPart {
  std::uint32_t levels = 0;       ///< of the whole ladder
  std::uint32_t first_level = 0;  ///< of the part
  /// By level of the part: members are at these levels in order, each at its own first scan.
  std::vector<double> inverse_temperatures;
  std::vector<std::vector<double>> proposal_scales;
  std::uint64_t end_scan = 0;  ///< no member begins it: the end of the round, or of the run
  /// Scans of all members together beyond which none is begun, each one's first aside.
  std::uint32_t scans_max = 1;
  friend bool operator==(const LadderPart&, const LadderPart&) = default;
};

struct Block {
  std::vector<Unit> members;         ///< at least one
  std::optional<LadderPart> ladder;  ///< none: one member, run as it is; else each has one scan
  friend bool operator==(const Block&, const Block&) = default;
};

/// How large a block may be.
struct BlockLimits {
  std::uint32_t unit_scans_max = 1;   ///< of a unit alone
  std::uint32_t block_scans_max = 1;  ///< of all members of a ladder's part together
  /// Threads that want blocks at once and could be fed with small ones. Where there is a ladder for
  /// each, one of up to so many levels is not split: parts leave edges, and what runs along these
  /// comes in small blocks.
  std::uint64_t threads = 1;
  std::uint32_t whole_levels_max = 0;
};

/// The state that a member begins with: as bytes, or nothing where the worker is thought to hold it
/// or the member starts.
using GivenState = std::optional<base::Bytes>;

/// What computes blocks. Thread-safe: run may be called from several threads at once.
class BlockWorker {
 public:
  virtual ~BlockWorker() = default;
  /// One result for each member, in order, each with the scans that it came to, at least one; none
  /// at all when a state is neither given nor held. REQUIRES: a state for each member.
  virtual std::vector<UnitResult> run(const Block& block,
                                      std::span<const GivenState> states) const = 0;
  virtual CacheUse cache_use() const = 0;
};

}  // namespace sleight::plan
