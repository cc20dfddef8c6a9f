// Decides when bodies come to rest, what holds them, and what wakes them.
//
// Idea. Slow bodies in contact bounce by micrometres for ever; restitution.h limits the rate of
// these impacts. Bodies that have been slow for rest_time_s and stand go to rest together
// (rest_decision.h). Decisions use only recorded contacts (rest_log.h), so they depend only on the
// events so far.
//
// A resting body is an obstacle. The supporters of a resting body are the bodies whose pushes
// balanced it. A resting body wakes when a collision or a user would give it a speed above
// wake_speed_mps(); weaker impacts act on it as on static geometry. A resting body also wakes when
// a supporter moves. A supporter moves if an impact wakes it, or if it becomes fast or leaves its
// place after its own supporter moved. So an impact doesn't wake a whole heap: a body that may have
// lost its support is tested, and the bodies on it keep resting unless it leaves its place.
//
// Invariants
//   1. Bodies go to rest only by a decision, which is made at the rest event of one such body.
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
  void reset(std::span<const RestingBody> bodies, const SlowContacts& rule, TickCount jam_span);
  bool enabled() const { return logs_.rule.rest_speed_mps > 0; }
  /// How long a touch counts.
  TickCount rest_span() const { return logs_.rest_span; }
  double wake_speed_mps() const;
  /// Whether a collision is slow, given the contact's separation speed and the speeds of the body's
  /// fastest point before and after the collision. A collision isn't slow if it separates the
  /// bodies faster than a slow bounce; otherwise bodies could freeze in the air.
  bool is_slow(double before_mps, double after_mps, double parting_mps) const;

  // Changes of a body's motion.
  /// Call when the body collides.
  void touched(BodyId body, const TouchRecord& record, bool slowly);
  /// Call when the body begins a segment in which it stays in contact. `slow_from`: first slow tick
  /// of the segment, or k_never.
  void stays(BodyId body, Tick now, Tick slow_from);
  /// Call when the body leaves a lasting contact without an impact.
  void flies(BodyId body, Tick now);
  /// Call when the body's motion changes for another reason.
  void disturbed(BodyId body);

  // Going to rest. All of these functions REQUIRE enabled().
  /// Tick of the body's next rest event; k_never if the body isn't slow.
  Tick due(BodyId body) const { return log_of(body).due; }
  /// Touches in the last rest_time_s, and possibly earlier ones.
  std::span<const TouchRecord> touches(BodyId body) const { return log_of(body).touches(); }
  void forget_old_touches(BodyId body, Tick now) { log_of(body).forget_before(now, rest_span()); }
  /// Records a lasting contact for the coming decision.
  void still_touches(BodyId body, const TouchRecord& touch) { log_of(body).record(touch); }
  RestDecision& decide(BodyId body, Tick now) {
    decision_.begin(logs_, body, now);
    return decision_;
  }
  /// Stores the place where a body rests, after a decision.
  void rests_at(BodyId body, const Vec3& centre_m) { log_of(body).rests_at_m = centre_m; }
  /// Puts a body to rest at its start. `touches` may hold the body. REQUIRES: at most
  /// k_touch_records_max touches and supporters each.
  void lies(BodyId body, const Vec3& centre_m, std::span<const TouchRecord> touches,
            std::span<const BodyId> supporters);

  // Waking.
  /// The bodies that a resting body leans on; empty if the body is awake.
  std::span<const BodyId> supporters(BodyId body) const;
  /// Marks the bodies that rest on a moving body as awake and returns them in ascending order.
  /// Bodies that rest on a returned body keep resting until it leaves its place. Valid until the
  /// next call.
  std::span<const BodyId> wake(BodyId body);
  /// Call when a body wakes without an impact, in the pose in which it rested.
  void woke(BodyId body, Tick now, const Pose& pose);
  /// Whether others may still rest on a body that woke.
  bool in_place(BodyId body) const { return enabled() && log_of(body).in_place; }
  /// Whether a woken body has left its place, given its current pose and speed.
  bool has_left(BodyId body, const Pose& pose, double speed_mps) const;
  /// Records that the body has left the place in which others rested on it.
  void leave(BodyId body) { log_of(body).in_place = log_of(body).has_place = false; }

  // Histories.
  /// Returns a body's state, for a simulation that resumes from here; appends its touches.
  RestState state_of(BodyId body, std::vector<TouchRecord>& touches) const;
  void restore(BodyId body, const RestState& state, std::span<const TouchRecord> touches);

 private:
  RestLog& log_of(BodyId body) { return logs_.logs[body]; }
  const RestLog& log_of(BodyId body) const { return logs_.logs[body]; }
  /// A woken body that is still in its place gets another rest event even if it isn't slow, because
  /// others may rest on it.
  Tick due_if_not_slow(const RestLog& log, Tick now) const {
    return log.in_place ? now + rest_span() : k_never;
  }

  RestLogs logs_;
  TickCount jam_span_ = 0;
  RestDecision decision_;
  std::vector<BodyId> woken_;
};

}  // namespace sleight::physics
