// What is known of bodies for decisions about rest: what each touched, since when it is slow, and
// what it rests on. resting.h says when it changes, rest_decision.h what follows from it.
//
// Thread safety: values.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/contact/touch_record.h"
#include "worker/physics/event/event.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/scene/scene.h"

namespace sleight::physics {

/// All that is known of a body but for its touches, which lie elsewhere, since most bodies touched
/// little.
struct RestState {
  Tick slow_since = k_never;
  Tick counted_since{};  ///< slow_collisions are counted from here
  Tick due = k_never;    ///< when the body asks next whether it may rest
  std::uint32_t slow_collisions = 0;
  std::uint32_t count = 0;  ///< touches of late
  std::uint32_t supporter_count = 0;
  std::array<BodyId, k_touch_records_max> supporters{};  ///< of a resting body
  std::uint32_t held_count = 0;                          ///< touches that may hold a resting body
  bool rests = false;
  bool rests_anyhow = false;            ///< whatever balances it
  BodyId must_bear = k_static_partner;  ///< another body, while that touches it
  bool has_place = false;               ///< some may have rested on it since it was there
  bool in_place = false;                ///< awake, and others may still rest on it
  Pose place{};
  Tick stays_since = k_never;  ///< slow, and about there all the time; as decisions found it
  Vec3 stays_at_m = Vec3::Zero();
  Vec3 rests_at_m = Vec3::Zero();  ///< a resting body's centre
  std::size_t first_touch = 0;     ///< in a list of touches: `count`, then `held_count`

  bool leans_on(BodyId other) const {
    const auto end = supporters.begin() + supporter_count;
    return std::find(supporters.begin(), end, other) != end;
  }
  /// Whether it rests, on that other one among others.
  bool rests_on(BodyId other) const { return rests && leans_on(other); }
  std::size_t touch_count() const { return count + held_count; }
};

struct RestLog : RestState {
  std::array<TouchRecord, k_touch_records_max> records;
  std::array<TouchRecord, k_touch_records_max> held;  ///< of a resting body

  std::span<const TouchRecord> touches() const { return {records.data(), count}; }
  std::span<const TouchRecord> holding() const { return {held.data(), held_count}; }
  /// Adds a touch, in the place of one at the same place of the same partner, or of the oldest.
  void record(const TouchRecord& touch);
  /// Forgets touches that are older than a span.
  void forget_before(Tick now, TickCount span);
  /// It is no longer slow, nor at rest.
  void disturb();
  bool is_jammed() const { return slow_collisions >= k_slow_collisions; }
};

/// What doesn't change about a body.
struct RestingBody {
  Vec3 weight_n = Vec3::Zero();
  double reach_m = 0;  ///< of its points from the centre, at most
  bool round = false;  ///< a sphere: it may stand where others would topple
};

/// All bodies, and the scene's rule.
struct RestLogs {
  SlowContacts rule;
  TickCount rest_span = 0;  ///< how long what a body touched counts
  std::vector<RestingBody> bodies;
  std::vector<RestLog> logs;
};

}  // namespace sleight::physics
