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
  const Tick from = mark != nullptr ? mark->tick : Tick{-1};
  is_gap = std::ranges::any_of(
      meetings, [&](const Meeting& meeting) { return meeting.tick > from && meeting.tick < tick; });
  return mark;
}

bool MarbleStory::is_alone_at(Tick tick) const {
  const auto next = std::ranges::upper_bound(parts, tick, {}, &Part::begin);
  return next != parts.begin() && (next - 1)->is_alone;
}

}  // namespace sleight::physics
