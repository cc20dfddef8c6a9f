// Decides when bodies come to rest, what holds them, and what wakes them.
//
// Idea. Slow bodies in contact bounce by micrometres for ever; restitution.h limits the rate of
// these impacts. Bodies go to rest together if they have been slow for rest_time_s and stand
// (rest_decision.h). Decisions use only recorded contacts (rest_log.h), so they depend only on the
// events so far.
//
// A resting body is an obstacle. The supporters of a resting body are the bodies whose pushes
// balanced it. A resting body wakes when a collision or a user would give it a speed above
// wake_speed_mps(). A weaker impact treats the resting body as static geometry. A resting body also
// wakes when a supporter moves. A supporter moves if an impact wakes it. If a supporter's own
// supporter moves, the supporter moves once it becomes fast or leaves its place. So an impact
// doesn't wake a whole heap. A body that may have lost its support is tested. If it stays in its
// place, the bodies on it keep resting.
//
// Invariants
//   1. Bodies go to rest only by a decision. A decision is made at the rest event of one of these
//      bodies.
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
  /// `jam_span`: a body is jammed after k_slow_collisions slow collisions within this span.
  /// Fixed bodies rest from now on; the functions below are never called with a fixed `body`.
  void reset(std::span<const RestingBody> bodies, const SlowContacts& rule, TickCount jam_span);
  bool enabled() const { return logs_.rule.rest_speed_mps > 0; }
  /// How long a touch counts.
  TickCount rest_span() const { return logs_.rest_span; }
  double wake_speed_mps() const;
  /// Returns whether a collision is slow. `before_mps` and `after_mps` are the speeds of the body's
  /// fastest point, `parting_mps` is the contact's separation speed. A collision isn't slow if it
  /// separates the bodies faster than a slow bounce. Without this rule, bodies could freeze in the
  /// air.
  bool is_slow(double before_mps, double after_mps, double parting_mps) const;

  // Changes of a body's motion.
  /// Call when the body collides.
  void touched(BodyId body, const TouchRecord& record, bool slowly);
  /// Call when the body begins a segment of lasting contact. `slow_from` is the segment's first
  /// slow tick, or k_never.
  void stays(BodyId body, Tick now, Tick slow_from);
  /// Call when the body leaves a lasting contact without an impact.
  void flies(BodyId body, Tick now);
  /// Call when the body's motion changes for another reason.
  void disturbed(BodyId body);

  // Going to rest. All of these functions REQUIRE enabled().
  /// Returns the tick of the body's next rest event, or k_never if the body isn't slow.
  Tick due(BodyId body) const { return log_of(body).due; }
  /// Returns the touches of the last rest_time_s. May also return earlier touches.
  std::span<const TouchRecord> touches(BodyId body) const { return log_of(body).touches(); }
  void forget_old_touches(BodyId body, Tick now) { log_of(body).forget_before(now, rest_span()); }
  /// Records a lasting contact for the coming decision.
  void still_touches(BodyId body, const TouchRecord& touch) { log_of(body).record(touch); }
  RestDecision& decide(BodyId body, Tick now) {
    decision_.begin(logs_, body, now);
    return decision_;
  }
  /// Call after a decision.
  void rests_at(BodyId body, const Vec3& centre_m) { log_of(body).rests_at_m = centre_m; }
  /// Puts a body to rest at its start. `touches` are the touches that may hold the body. REQUIRES:
  /// at most k_touch_records_max touches and supporters each.
  void lies(BodyId body, const Vec3& centre_m, std::span<const TouchRecord> touches,
            std::span<const BodyId> supporters);

  // Waking.
  /// Returns the bodies that a resting body leans on. If the body is awake, returns none.
  std::span<const BodyId> supporters(BodyId body) const;
  /// Marks the bodies that rest on a moving body as awake. Returns them in ascending order; the
  /// result is valid until the next call. Bodies that rest on a returned body keep resting until
  /// the returned body leaves its place.
  std::span<const BodyId> wake(BodyId body);
  /// Call when a body wakes without an impact, in the pose in which it rested.
  void woke(BodyId body, Tick now, const Pose& pose);
  /// Returns whether others may still rest on a body that woke.
  bool in_place(BodyId body) const { return enabled() && log_of(body).in_place; }
  /// Returns whether a woken body with this pose and speed has left its place.
  bool has_left(BodyId body, const Pose& pose, double speed_mps) const;
  /// Records that the body has left the place where others rested on it.
  void leave(BodyId body) { log_of(body).in_place = log_of(body).has_place = false; }

  // Histories.
  /// Returns a body's state and appends its touches. A simulation needs both to resume from here.
  RestState state_of(BodyId body, std::vector<TouchRecord>& touches) const;
  void restore(BodyId body, const RestState& state, std::span<const TouchRecord> touches);

 private:
  RestLog& log_of(BodyId body) { return logs_.logs[body]; }
  const RestLog& log_of(BodyId body) const { return logs_.logs[body]; }
  /// If a woken body is still in its place, others may rest on it. So it gets another rest event
  /// even if it isn't slow.
  Tick due_if_not_slow(const RestLog& log, Tick now) const {
    return log.in_place ? now + rest_span() : k_never;
  }

  RestLogs logs_;
  TickCount jam_span_ = 0;
  RestDecision decision_;
  std::vector<BodyId> woken_;
};

}  // namespace sleight::physics
