#include "worker/sampling/swap_flow.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/sampling/swap.h"

namespace sleight::sampling {

SwapFlow::SwapFlow(FlowLevels levels)
    : levels_(std::move(levels)), seats_(levels_.inverse_temperatures.size()) {
  CHECK_LE(levels_.first_level + seats_.size(), std::size_t{levels_.levels});
}

void SwapFlow::sit(std::uint32_t level, std::uint32_t replica, std::uint64_t scan) {
  seats_[level] = {.replica = replica, .scan = scan, .log_constraint = {}};
}

std::span<const SwapFlow::GoesOn> SwapFlow::made(std::uint32_t level, double log_constraint) {
  CHECK(seats_[level].may_run());
  going_count_ = 0;
  Seat& seat = seats_[level];
  seat.log_constraint = log_constraint;
  const std::optional<std::uint32_t> partner =
      even_odd_partner(levels_.first_level + level, seat.scan, levels_.levels);
  if (!partner) {
    go_on(level, *seat.replica);
    return {going_.data(), going_count_};
  }
  const std::uint32_t other = *partner - levels_.first_level;  // Wraps below the first level.
  if (other >= seats_.size()) {
    seat = {.replica = {}, .scan = seat.scan, .log_constraint = {}};
    return {};
  }
  const bool both_made = seats_[other].log_constraint && seats_[other].scan == seat.scan;
  if (!both_made) return {};

  const std::uint32_t hotter = std::min(level, other);
  const bool swapped = swap_at(hotter);
  const std::uint32_t from_hotter = *seats_[hotter].replica;
  const std::uint32_t from_cooler = *seats_[hotter + 1].replica;
  go_on(hotter, swapped ? from_cooler : from_hotter);
  go_on(hotter + 1, swapped ? from_hotter : from_cooler);
  return {going_.data(), going_count_};
}

/// Returns whether the states at a level and the next cooler level swap.
bool SwapFlow::swap_at(std::uint32_t hotter) const {
  return swaps({.seed = levels_.seed,
                .chain = levels_.chain,
                .level = levels_.first_level + hotter,
                .scan = seats_[hotter].scan},
               {.hotter = levels_.inverse_temperatures[hotter],
                .cooler = levels_.inverse_temperatures[hotter + 1],
                .log_constraint_hotter = *seats_[hotter].log_constraint,
                .log_constraint_cooler = *seats_[hotter + 1].log_constraint});
}

void SwapFlow::go_on(std::uint32_t level, std::uint32_t replica) {
  const std::uint64_t scan = seats_[level].scan + 1;
  sit(level, replica, scan);
  going_[going_count_++] = {.replica = replica, .level = level, .scan = scan};
}

}  // namespace sleight::sampling
