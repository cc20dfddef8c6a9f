#include "worker/physics/marbles/marble_history.h"

#include <algorithm>

namespace sleight::physics {

const MarbleHistory::Checkpoint* MarbleHistory::checkpoint_before(Tick tick, bool& is_gap) const {
  const Checkpoint* checkpoint = nullptr;
  if (last.tick < tick) {
    checkpoint = &last;
  } else {
    const auto after = std::ranges::lower_bound(checkpoints, tick, {}, &Checkpoint::tick);
    if (after != checkpoints.begin()) checkpoint = &*(after - 1);
  }
  // If several meetings had the same tick, only the first of them may still have a checkpoint.
  const std::size_t known = checkpoint != nullptr ? checkpoint->meetings : 0;
  is_gap = known < meetings.size() && meetings[known].tick < tick;
  return checkpoint;
}

bool MarbleHistory::is_alone_at(Tick tick) const {
  const auto next = std::ranges::upper_bound(parts, tick, {}, &Part::begin);
  return next != parts.begin() && (next - 1)->is_alone;
}

}  // namespace sleight::physics
