// Replaying the history of another simulation: bodies of the templates in engine.h.
//
// A replayed body has a box and pairs as any other. Its pairs with others that are replayed are
// not predicted, nor is static geometry, and it asks for no decisions: what comes of these is in
// the history. The queue's slot OwnSlot::replayed holds the history's next event.
#pragma once

#include "worker/physics/simulator/engine.h"

namespace sleight::physics {

/// A body has started; whether it is replayed from now on.
template <BroadPhase Boxes, EventQueue Queue>
bool Engine<Boxes, Queue>::starts_as_before(BodyId body, const EventKey& event) {
  const bool same = replaying_.starts(body, event);
  if (same) {
    // Its place was free of static geometry for the next tick, which is all that the list says.
    for (StaticEdge& edge : statics_[body])
      predictions_.end_search(edge.search);
    if (options_.algorithm != Algorithm::all_pairs) {
      statics_[body].clear();
      replaying_.comes_into(body, boxes_.box({body}));
    } else if (replaying_.statics_differ()) {
      world_.replayed().make_live(body);  // without boxes its coming near would go unnoticed
    }
  }
  schedule_replay();
  return same;
}

/// The history's next event; whether it was replayed.
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
  // Controls that both have come by themselves, in the order that the scene gives.
  const bool comes_by_itself =
      next.kind == EventKind::control && next.feature < replaying_.same_controls();
  if (next == k_no_event || comes_by_itself) {
    queue_.erase(slot_of(OwnSlot::replayed));
  } else {
    queue_.set(slot_of(OwnSlot::replayed), next);
  }
}

/// Bodies that have gone live are simulated from now on.
template <BroadPhase Boxes, EventQueue Queue>
void Engine<Boxes, Queue>::take_over_live() {
  for (const BodyId body : replaying_.make_supporters_live()) {
    if (options_.algorithm == Algorithm::asynchronous) watch_statics(body, boxes_.box({body}));
    if (options_.algorithm == Algorithm::synchronous) watch_statics(body, all_boxes_[body]);
    predict_all(body);
  }
  world_.replayed().forget_gone_live();
  // Boxes were made to last until the event that came next, which is withdrawn if it was a void
  // prediction of theirs.
  if (options_.algorithm == Algorithm::synchronous && boxes_until_ != k_never &&
      (queue_.empty() || queue_.least().key.tick > boxes_until_)) {
    queue_.set(
        slot_of(OwnSlot::new_boxes),
        {.tick = boxes_until_, .kind = EventKind::update, .lower = k_nobody, .higher = k_nobody});
  }
}

}  // namespace sleight::physics
