// Replays the history of another simulation in a world, as far as it is the same (replay.h says
// when that is).
//
// Thread safety: none.
#pragma once

#include <memory>
#include <span>

#include "worker/physics/broad_phase/box.h"
#include "worker/physics/reuse/replay.h"
#include "worker/physics/simulator/world.h"

namespace sleight::physics {

class Replaying {
 public:
  /// Borrows the world. Without a history nothing is replayed; nor if all may be otherwise.
  /// REQUIRES: nothing has happened yet.
  Replaying(World& world, std::shared_ptr<const History> history);

  /// Whether anything is, or may still be.
  bool active() const { return replay_ != nullptr; }
  /// A replayed body comes near a place where static geometry differs, if it does: it goes live.
  void comes_into(BodyId body, const Box& box) {
    ReplayedBodies& replayed = world_.replayed();
    if (replayed.has(body) && replay_->changes.places.meet(box)) replayed.make_live(body);
  }
  bool statics_differ() const { return replay_ && !replay_->changes.places.none(); }
  /// Of the bodies that have gone live of late, what they rest on goes live as well: it must find
  /// them if it moves. All of these.
  std::span<const BodyId> make_supporters_live();

  // REQUIRES, of the rest: active().
  /// Nothing but what the history has happens before this tick.
  Tick quiet_until() const { return replay_->quiet_until; }
  /// All that happens before that tick, and up to and at `end`; up to where that was. REQUIRES: no
  /// other events were processed.
  Tick skip_quiet(Tick end);
  /// A body has started: whether it is replayed from now on.
  bool starts(BodyId body, const EventKey& event);
  /// The key of the history's next event of bodies that are replayed; or of its end.
  EventKey next();
  /// Replays the next event if all its participants are replayed; otherwise makes those that are
  /// live. Whether it was replayed: the world's changed() then lists the bodies that began a
  /// segment.
  bool play();
  /// How many of the scene's controls, in order, are the history's.
  std::size_t same_controls() const { return replay_->changes.same_controls; }
  /// Ends it if no body is replayed, or will be.
  void end_if_over() {
    if (!world_.replayed().any() && replay_->awaited_count == 0) replay_ = nullptr;
  }

 private:
  void find_quiet_until();

  Bodies& bodies() { return world_.bodies(); }

  World& world_;
  std::unique_ptr<Replay> replay_;
};

}  // namespace sleight::physics
