// Stores the data for rest decisions: what each body touched, since when it has been slow, and what
// it rests on. resting.h changes the data; rest_decision.h evaluates them.
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

/// A body's data without its touches. Most bodies have few touches, so these are stored separately.
struct RestState {
  Tick slow_since = k_never;
  Tick counted_since{};  ///< start of the count slow_collisions
  Tick due = k_never;    ///< next rest event
  std::uint32_t slow_collisions = 0;
  std::uint32_t count = 0;  ///< recent touches
  std::uint32_t supporter_count = 0;
  std::array<BodyId, k_touch_records_max> supporters{};  ///< bodies that a resting body rests on
  std::uint32_t held_count = 0;                          ///< touches that may hold a resting body
  bool rests = false;
  bool rests_anyhow = false;            ///< regardless of balance
  BodyId must_bear = k_static_partner;  ///< a body that this one must bear while they touch
  bool has_place = false;               ///< others may have rested on it at `place`
  bool in_place = false;                ///< awake, but others may still rest on it
  Pose place{};
  Tick stays_since = k_never;  ///< slow and near stays_at_m since then, as decisions found
  Vec3 stays_at_m = Vec3::Zero();
  Vec3 rests_at_m = Vec3::Zero();  ///< a resting body's centre
  std::size_t first_touch = 0;     ///< in a list of touches: `count`, then `held_count`

  bool leans_on(BodyId other) const {
    const auto end = supporters.begin() + supporter_count;
    return std::find(supporters.begin(), end, other) != end;
  }
  bool rests_on(BodyId other) const { return rests && leans_on(other); }
  std::size_t touch_count() const { return count + held_count; }
};

struct RestLog : RestState {
  std::array<TouchRecord, k_touch_records_max> records;
  std::array<TouchRecord, k_touch_records_max> held;  ///< of a resting body

  std::span<const TouchRecord> touches() const { return {records.data(), count}; }
  std::span<const TouchRecord> holding() const { return {held.data(), held_count}; }
  /// Adds a touch. If there is a touch of the same partner at the same place, replaces it.
  /// Otherwise, if the list is full, replaces the oldest touch.
  void record(const TouchRecord& touch);
  void forget_before(Tick now, TickCount span);
  /// Marks the body as neither slow nor at rest.
  void disturb();
  bool is_jammed() const { return slow_collisions >= k_slow_collisions; }
};

/// A body's constants.
struct RestingBody {
  Vec3 weight_n = Vec3::Zero();
  double reach_m = 0;  ///< maximum distance of its points from the centre
  bool round = false;  ///< a sphere: may stand where other bodies would topple
  bool fixed = false;  ///< never moves; others rest on it as on static geometry
};

struct RestLogs {
  SlowContacts rule;
  TickCount rest_span = 0;  ///< how long a touch counts
  std::vector<RestingBody> bodies;
  std::vector<RestLog> logs;

  /// Whether a touch's partner is static geometry or a fixed body.
  bool is_fixed(BodyId partner) const {
    return partner == k_static_partner || bodies[partner].fixed;
  }
};

}  // namespace sleight::physics
