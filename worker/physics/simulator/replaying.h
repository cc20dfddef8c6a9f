// Replays another simulation's history in a world, as far as both agree (replay.h).
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
  /// Borrows the world. Replays nothing if there is no history, or if everything may differ.
  /// REQUIRES: nothing has happened yet.
  Replaying(World& world, std::shared_ptr<const History> history);

  /// Whether any body is replayed or may be replayed later.
  bool active() const { return replay_ != nullptr; }
  /// Makes a replayed body live if it comes near a place where static geometry differs.
  void comes_into(BodyId body, const Box& box) {
    ReplayedBodies& replayed = world_.replayed();
    if (replayed.has(body) && replay_->changes.places.meet(box)) replayed.make_live(body);
  }
  bool statics_differ() const { return replay_ && !replay_->changes.places.none(); }
  /// If a body has gone live, makes its supporters live too, because a moving supporter must wake
  /// it. Returns all bodies that have gone live.
  std::span<const BodyId> make_supporters_live();

  // These functions REQUIRE active().
  /// Before this tick, only the history's events happen.
  Tick quiet_until() const { return replay_->quiet_until; }
  /// Replays all events up to and at `end`, but only those before quiet_until(). Returns the last
  /// tick replayed. REQUIRES: no other events were processed.
  Tick skip_quiet(Tick end);
  /// Processes the start of a body. Returns whether the body is replayed from now on. A body that
  /// starts at rest is replayed only if it touches and leans on the same as in the history.
  bool starts(BodyId body, const EventKey& event);
  /// Finds the history's next event in which a replayed or awaited body takes part, and returns the
  /// event's key. If there is no such event, returns a key after the history's end.
  EventKey next();
  /// If all participants of the next event are replayed, replays it. Otherwise makes its
  /// participants live. Returns whether the event was replayed. If so, the world's changed() lists
  /// the bodies that began a segment.
  bool play();
  /// Counts the controls that scene and history share: those before the first difference.
  std::size_t same_controls() const { return replay_->changes.same_controls; }
  /// Ends the replay if no body is replayed or will be replayed.
  void end_if_over() {
    if (!world_.replayed().any() && replay_->awaited_count == 0) replay_ = nullptr;
  }

 private:
  void find_quiet_until();
  /// Whether an event of the history is an impact whose noise differs now.
  bool has_other_noise(const HistoryEvent& event) const;
  /// Whether a body that has just begun equals its state after a start event of the history.
  bool begins_as(BodyId body, const HistoryEvent& start);

  Bodies& bodies() { return world_.bodies(); }

  World& world_;
  std::unique_ptr<Replay> replay_;
};

}  // namespace sleight::physics
