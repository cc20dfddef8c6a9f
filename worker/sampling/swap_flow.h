// The order of scans and swaps in a ladder: how replicas move through neighbouring levels, and
// which replicas wait for each other.
//
// Idea. Each level has a seat: the replica at that level, and the replica's scan there. After the
// scan, the level's partner (swap.h) determines the next step:
//
//   1. Without a partner, the replica continues at its level.
//   2. If the partner is outside this part, the replica leaves. The replica's next level isn't
//      known here.
//   3. If the partner has not made its scan, the replica waits.
//   4. If the partner has made its scan, the two swap or don't (swap.h), and both continue.
//
//   scan s     . a b c d e .     a part of a longer ladder: a and b swap, c and d; e leaves
//        s+1     a b c d         b and c swap; a leaves, d waits for the level that e has left
//        s+2       b c
//
// So each replica waits for at most one other replica, and replicas on both sides of a slow replica
// can run ahead. After a replica has left a level, later partners of that level wait until the end.
// Plans apply these rules to whole ladders (ladder_run.h). Workers apply these rules to the part in
// their block (block_runner.h). Invariant: the flow depends on the reported densities, but not on
// the order of the reports. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/ids.h"

namespace sleight::sampling {

/// Neighbouring levels of a ladder, or the whole ladder. SwapFlow counts levels from `first_level`.
struct FlowLevels {
  std::uint64_t seed = 0;
  base::ChainId chain;
  std::uint32_t levels = 0;       ///< Levels of the whole ladder.
  std::uint32_t first_level = 0;  ///< First level of this part.
  std::vector<double> inverse_temperatures;
};

class SwapFlow {
 public:
  struct Seat {
    std::optional<std::uint32_t> replica;  ///< Empty if the replica left or never came.
    std::uint64_t scan = 0;
    /// log p_c of the state after the scan. While log p_c is set, the replica waits for its
    /// partner.
    std::optional<double> log_constraint;

    bool may_run() const { return replica && !log_constraint; }
  };
  /// A replica whose level at its next scan is known.
  struct GoesOn {
    std::uint32_t replica = 0;
    std::uint32_t level = 0;
    std::uint64_t scan = 0;
  };

  explicit SwapFlow(FlowLevels levels);

  std::uint32_t size() const { return static_cast<std::uint32_t>(seats_.size()); }
  const Seat& seat(std::uint32_t level) const { return seats_[level]; }

  void sit(std::uint32_t level, std::uint32_t replica, std::uint64_t scan);

  /// Reports that a level's scan is made. Returns the replicas (at most two) that can now continue.
  /// The result is valid until the next call. REQUIRES: the level's seat has may_run().
  std::span<const GoesOn> made(std::uint32_t level, double log_constraint);

 private:
  bool swap_at(std::uint32_t hotter) const;
  void go_on(std::uint32_t level, std::uint32_t replica);

  FlowLevels levels_;
  std::vector<Seat> seats_;  ///< By level.
  std::array<GoesOn, 2> going_;
  std::size_t going_count_ = 0;
};

}  // namespace sleight::sampling
