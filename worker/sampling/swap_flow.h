// Who waits for whom in a ladder: how replicas go from scan to scan through neighbouring levels,
// and swap on the way.
//
// Idea. Each level has a seat: the replica that is at it, and the scan that this one makes there.
// What follows when the scan is made hangs on the level's partner after it (swap.h):
//
//   no partner              the replica goes on at its level
//   partner outside         the replica leaves: whoever sees both levels knows its next one
//   partner has not made    the replica waits
//     the scan yet
//   partner has made it     the two swap or don't (swap.h), and both go on
//
//   scan s     . a b c d e .     a part of a longer ladder: a and b swap, c and d; e leaves
//        s+1     a b c d         b and c swap; a leaves, d waits for the level that e has left
//        s+2       b c
//
// So a replica waits for one other at a time, and those on either side of a slow one run ahead.
// Where one has left, its later partners here wait for good.
// The plan lets whole ladders flow
// (ladder_run.h), a worker the part that its block has (block_runner.h): both decide by this.
//
// Invariant: what happens is a function of the densities told, not of the order across levels in
// which they are told.
// Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/ids.h"

namespace sleight::sampling {

/// Neighbouring levels of a ladder, or all of it. Levels are counted from `first_level` below.
struct FlowLevels {
  std::uint64_t seed = 0;
  base::ChainId chain;
  std::uint32_t levels = 0;       ///< of the whole ladder
  std::uint32_t first_level = 0;  ///< of those that are here
  std::vector<double> inverse_temperatures;
};

class SwapFlow {
 public:
  struct Seat {
    std::optional<std::uint32_t> replica;  ///< none: it has left, or never came
    std::uint64_t scan = 0;
    /// log p_c of the state after the scan, once it is made; then the swap waits for the partner.
    std::optional<double> log_constraint;

    bool may_run() const { return replica && !log_constraint; }
  };
  /// A replica's level at its next scan is known.
  struct GoesOn {
    std::uint32_t replica = 0;
    std::uint32_t level = 0;
    std::uint64_t scan = 0;
  };

  explicit SwapFlow(FlowLevels levels);

  std::uint32_t size() const { return static_cast<std::uint32_t>(seats_.size()); }
  const Seat& seat(std::uint32_t level) const { return seats_[level]; }

  /// Where a replica begins.
  void sit(std::uint32_t level, std::uint32_t replica, std::uint64_t scan);

  /// The scan at a level is made. Who goes on because of it, at most two; valid until the next
  /// call. REQUIRES: its seat may run.
  std::span<const GoesOn> made(std::uint32_t level, double log_constraint);

 private:
  bool swap_at(std::uint32_t hotter) const;
  void go_on(std::uint32_t level, std::uint32_t replica);

  FlowLevels levels_;
  std::vector<Seat> seats_;  ///< by level
  std::array<GoesOn, 2> going_;
  std::size_t going_count_ = 0;
};

}  // namespace sleight::sampling
