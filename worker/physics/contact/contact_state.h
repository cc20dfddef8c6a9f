// A body's contact state beside its segment: the bodies that it touched, the features that it stays
// on, how often it collides.
//
// Thread safety: values.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "worker/physics/contact/lasting_contact.h"
#include "worker/physics/contact/rest_log.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {

/// What a body in contact stays on.
struct Supports {
  std::array<StaticId, 3> features{};
  std::uint32_t count = 0;
  Tick end = k_never;                ///< of the segment's accelerations
  FeatureId leaves = Stay::k_none;   ///< the one whose region the centre leaves then, if any
  std::uint32_t face = 0;            ///< of a polyhedron that a body lies on
  Tick met_body{-k_tick_max.value};  ///< when it last collided with another body
  Vec3 half_way = Vec3::Zero();      ///< of a piece over an edge (lasting_contact.h)
  // Of a body that is no sphere: what static piece it hit last, and when it last hit one soon after
  // another.
  StaticId last_hit{UINT32_MAX};
  Tick hit{-k_tick_max.value};
  Tick hit_both{-k_tick_max.value};
  void hits(StaticId piece, Tick now, TickCount soon) {
    if (last_hit != piece && now - hit < soon) hit_both = now;
    last_hit = piece;
    hit = now;
  }
  std::span<const StaticId> all() const { return std::span(features).first(count); }
  bool holds(StaticId feature) const { return std::ranges::find(all(), feature) != all().end(); }
};

/// How often a body has collided at its last tick, and in a window of time.
struct CollisionCount {
  Tick tick{-1};
  Tick window{};
  std::uint32_t at_tick = 0;
  std::uint32_t in_window = 0;

  /// One more.
  void add(Tick now) {
    at_tick = tick == now ? at_tick + 1 : 1;
    tick = now;
    if (now - window > k_window) {
      window = now;
      in_window = 0;
    }
    ++in_window;
  }
  /// So many that the simulation can't go on.
  bool is_too_much() const {
    return at_tick > k_events_at_a_tick_max || in_window > k_collisions_in_window_max;
  }
};
/// What such a body does, for people. `slow_contacts_end`: whether the scene says how these end.
std::string words_of_too_much(const CollisionCount& count, bool slow_contacts_end);

/// All contact state but for two parts: the touches lie in a list of TouchRecord (rest_log.h), and
/// the counts and times of collisions follow from the event itself (World::restore).
struct ContactState {
  RestState rest;
  Supports supports;
};

}  // namespace sleight::physics
