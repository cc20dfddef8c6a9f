// Bodies that are left alone: bodies of the templates in engine.h.
//
// A body that can't leave a box by itself any more changes nothing outside of that. So its events
// wait until the box of another body overlaps it, and are then made up for, up to the present:
// until then nothing else can have touched it, and it has touched nothing else. What happens is the
// same, bit for bit; what is spared is what nobody asks for.
#pragma once

#include <algorithm>

#include "worker/physics/simulator/engine.h"

namespace sleight::physics {

/// A body's motion has changed: leaves it alone if it may be. False if it goes on.
template <BroadPhase Boxes, EventQueue Queue>
bool Engine<Boxes, Queue>::suspend(std::uint32_t body) {
  // What has neighbours mostly has them in its confinement too.
  if (!options_.confinement || catches_up_ || !graph_.others_of(body).empty()) return false;
  const Segment& segment = world_.segment(body);
  if (segment.mode == MotionMode::resting || world_.has_met_lately(body, now_)) return false;
  const std::optional<Box> box = options_.confinement({body}, segment);
  if (!box) return false;
  Sink sink{*this, body, false};
  boxes_.move({body}, *box, sink);
  if (!graph_.others_of(body).empty()) {
    renew_box(body, false);  // the static geometry that is watched is not that of this box
    return false;
  }
  suspended_[body] = Suspended::yes;
  queue_.erase({body});
  ++counts_.suspensions;
  return true;
}

/// Those that something has come near to catch up with the present: all their events before one
/// that is taking place.
template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::resume(const EventKey& present) {
  const Tick now = now_;
  catches_up_ = true;
  while (!failure_) {
    if (!to_resume_.empty()) {
      const std::uint32_t body = to_resume_.back();
      to_resume_.pop_back();
      suspended_[body] = Suspended::no;
      now_ = world_.segment(body).flight.begin;
      renew_box(body, false);
      predict_all(body);
      continue;
    }
    const QueuedEvent event = queue_.least();
    if (!(event.key < present)) break;
    now_ = event.key.tick;
    process(event);
    if (!world_.failure().empty()) fail(SceneError::Kind::search_failed, world_.failure());
  }
  catches_up_ = false;
  now_ = now;
}

}  // namespace sleight::physics
