// Implements templates of engine.h that replay another simulation's history.
//
// A replayed body has a box and pairs like any other body. The history contains a replayed body's
// rest decisions, and its collisions with static geometry and with other replayed bodies. So these
// events are not predicted. The queue's slot OwnSlot::replayed holds the history's next event.
#pragma once

#include "worker/physics/simulator/engine.h"

namespace sleight::physics {

/// Processes the start of a body. Returns whether the body is replayed from now on.
template <BroadPhase Boxes, EventQueue Queue>
bool Engine<Boxes, Queue>::starts_as_before(BodyId body, const EventKey& event) {
  const bool same = replaying_.starts(body, event);
  if (same) {
    // The history shows that nothing is in the way at the start. So end the searches for collisions
    // with static geometry.
    for (StaticEdge& edge : statics_[body])
      predictions_.end_search(edge.search);
    if (options_.algorithm != Algorithm::all_pairs) {
      statics_[body].clear();
      replaying_.comes_into(body, boxes_.box({body}));
    } else if (replaying_.statics_differ()) {
      world_.replayed().make_live(
          body);  // without boxes, nothing would detect that the body comes near
    }
  }
  schedule_replay();
  return same;
}

/// Processes the history's next event. Returns whether it was replayed.
template <BroadPhase Boxes, EventQueue Queue>
bool Engine<Boxes, Queue>::replay() {
  const bool played = replaying_.play();
  if (played) {
    ++counts_.replayed;
    bodies_changed();
  }
  schedule_replay();
  return played;
}

template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::schedule_replay() {
  if (replaying_.active()) replaying_.end_if_over();
  const EventKey next = replaying_.active() ? replaying_.next() : k_no_event;
  // If both scenes have a control, it is processed from the control slot, in the scene's order.
  const bool comes_by_itself =
      next.kind == EventKind::control && next.feature < replaying_.same_controls();
  if (next == k_no_event || comes_by_itself) {
    queue_.erase(slot_of(OwnSlot::replayed));
  } else {
    queue_.set(slot_of(OwnSlot::replayed), next);
  }
}

/// Starts to simulate the bodies that have gone live.
template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::take_over_live() {
  for (const BodyId body : replaying_.make_supporters_live()) {
    if (options_.algorithm == Algorithm::asynchronous) watch_statics(body, boxes_.box({body}));
    if (options_.algorithm == Algorithm::synchronous) watch_statics(body, all_boxes_[body]);
    predict_all(body);
  }
  world_.replayed().forget_gone_live();
  // Boxes expire at the tick of the event that was next when they were made. Boxes keep this expiry
  // even if that event was void and has been removed.
  if (options_.algorithm == Algorithm::synchronous && boxes_until_ != k_never &&
      (queue_.empty() || queue_.least().key.tick > boxes_until_)) {
    queue_.set(
        slot_of(OwnSlot::new_boxes),
        {.tick = boxes_until_, .kind = EventKind::update, .lower = k_nobody, .higher = k_nobody});
  }
}

}  // namespace sleight::physics
