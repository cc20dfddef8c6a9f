// When do bodies come to rest, what holds them, and what wakes them?
//
// Idea. Slow bodies in contact bounce by micrometres for ever (restitution.h keeps the rate of
// these impacts bounded). Those that have been slow for rest_time_s and stand go to rest together
// (rest_decision.h). Everything is read from recorded contacts (rest_log.h), so a decision is a
// function of the events so far.
//
// A resting body is an obstacle. The bodies that pushed in its balance are its supporters. It wakes
// when a collision, or a user, would give it a speed above wake_speed_mps(); below, it takes the
// blow as static geometry does. It also wakes when a supporter moves. A supporter moves if it wakes
// from a blow, or if its own supporter moved and it then is fast or leaves its place. So a blow
// does not wake a whole heap: a body that may have lost its support is looked at, and the bodies on
// it sleep on unless it leaves its place.
//
// Invariants
//   1. A body rests only by a decision, which is made at its own rest event.
//   2. Nothing is allocated after reset().
// Thread safety: none.
#pragma once

#include <span>
#include <vector>

#include "worker/physics/contact/rest_decision.h"
#include "worker/physics/contact/rest_log.h"

namespace sleight::physics {

class Resting {
 public:
  /// So many slow collisions as make a body jammed must come within a span.
  void reset(std::span<const RestingBody> bodies, const SlowContacts& rule, TickCount jam_span);
  bool enabled() const { return logs_.rule.rest_speed_mps > 0; }
  /// How long what a body touched counts.
  TickCount rest_span() const { return logs_.rest_span; }
  double wake_speed_mps() const;
  /// Whether a collision of a body is a slow one, by its fastest point's speed before and after,
  /// and by how fast the contact parts. One that parts faster than slow bounces do is not slow: the
  /// body would freeze in the air.
  bool is_slow(double before_mps, double after_mps, double parting_mps) const;

  // A body's motion changes.
  /// It collides.
  void touched(BodyId body, const TouchRecord& record, bool slowly);
  /// It begins a segment in which it stays in contact; it is slow from a tick of that on, or not
  /// (k_never).
  void stays(BodyId body, Tick now, Tick slow_from);
  /// It leaves that contact without a blow.
  void flies(BodyId body, Tick now);
  /// It changes for another reason.
  void disturbed(BodyId body);

  // Going to rest. REQUIRES, of these: enabled().
  /// When the body asks next whether it may rest; k_never if it isn't slow.
  Tick due(BodyId body) const { return log_of(body).due; }
  /// What it touched in the last rest_time_s, and perhaps longer ago.
  std::span<const TouchRecord> touches(BodyId body) const { return log_of(body).touches(); }
  void forget_old_touches(BodyId body, Tick now) { log_of(body).forget_before(now, rest_span()); }
  /// A contact that lasts, for the decision that is about to be made.
  void still_touches(BodyId body, const TouchRecord& touch) { log_of(body).record(touch); }
  /// Begins the decision at a body's rest event.
  RestDecision& decide(BodyId body, Tick now) {
    decision_.begin(logs_, body, now);
    return decision_;
  }
  /// A body has begun to rest at a place, as decided.
  void rests_at(BodyId body, const Vec3& centre_m) { log_of(body).rests_at_m = centre_m; }
  /// A body begins at rest, on some others; what may hold it. REQUIRES: at most k_touch_records_max
  /// of either.
  void lies(BodyId body, const Vec3& centre_m, std::span<const TouchRecord> touches,
            std::span<const BodyId> supporters);

  // Waking.
  /// The bodies that a resting one leans on; none of one that is awake.
  std::span<const BodyId> supporters(BodyId body) const;
  /// A body moves: the bodies that rest on it, in ascending order. They are no longer resting.
  /// Those that rest on them still do, until they leave their place. Valid until the next call.
  std::span<const BodyId> wake(BodyId body);
  /// A body woke without a blow, where it rested.
  void woke(BodyId body, Tick now, const Pose& pose);
  /// Whether others may still rest on a body that woke.
  bool in_place(BodyId body) const { return enabled() && log_of(body).in_place; }
  /// Whether such a body, in another pose and at a speed by now, has left its place.
  bool has_left(BodyId body, const Pose& pose, double speed_mps) const;
  /// It is in no place any more.
  void leave(BodyId body) { log_of(body).in_place = log_of(body).has_place = false; }

  // Histories.
  /// All that is known of a body, for a simulation that resumes from here; appends its touches.
  RestState state_of(BodyId body, std::vector<TouchRecord>& touches) const;
  void restore(BodyId body, const RestState& state, std::span<const TouchRecord> touches);

 private:
  RestLog& log_of(BodyId body) { return logs_.logs[body]; }
  const RestLog& log_of(BodyId body) const { return logs_.logs[body]; }
  /// A body in its place is looked at again anyway: others may rest on it.
  Tick due_if_not_slow(const RestLog& log, Tick now) const {
    return log.in_place ? now + rest_span() : k_never;
  }

  RestLogs logs_;
  TickCount jam_span_ = 0;
  RestDecision decision_;
  std::vector<BodyId> woken_;
};

}  // namespace sleight::physics
