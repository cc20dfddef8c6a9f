#include "worker/physics/marbles/marble_story.h"

#include <algorithm>

namespace sleight::physics {

const MarbleStory::Mark* MarbleStory::mark_before(Tick tick, bool& is_gap) const {
  const Mark* mark = nullptr;
  if (last.tick < tick) {
    mark = &last;
  } else {
    const auto after = std::ranges::lower_bound(marks, tick, {}, &Mark::tick);
    if (after != marks.begin()) mark = &*(after - 1);
  }
  // Of several meetings at a tick the first one's mark may be all that is left.
  const std::size_t known = mark != nullptr ? mark->meetings : 0;
  is_gap = known < meetings.size() && meetings[known].tick < tick;
  return mark;
}

bool MarbleStory::is_alone_at(Tick tick) const {
  const auto next = std::ranges::upper_bound(parts, tick, {}, &Part::begin);
  return next != parts.begin() && (next - 1)->is_alone;
}

}  // namespace sleight::physics
