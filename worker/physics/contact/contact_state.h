// A body's contact state: recent touches, supporting features and collision counts. Its segment is
// stored elsewhere.
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

/// The features that a body stays on, and related state.
struct Supports {
  std::array<StaticId, 3> features{};
  std::uint32_t count = 0;
  Tick end = k_never;               ///< end of the segment's accelerations
  FeatureId leaves = Stay::k_none;  ///< the feature whose region the centre leaves at `end`, if any
  std::uint32_t face = 0;           ///< face of a polyhedron on which the body lies
  Tick met_body{-k_tick_max.value};  ///< last collision with another body
  Vec3 half_way = Vec3::Zero();      ///< for a piece over an edge (lasting_contact.h)
  // Used for bodies that aren't spheres. `last_hit` is the last static piece that the body hit.
  // `hit_both` is the last tick at which the body hit a piece soon after another piece.
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

/// Counts a body's collisions: at the tick of the last collision, and in a time window.
struct CollisionCount {
  Tick tick{-1};
  Tick window{};
  std::uint32_t at_tick = 0;
  std::uint32_t in_window = 0;

  void add(Tick now) {
    at_tick = tick == now ? at_tick + 1 : 1;
    tick = now;
    if (now - window > k_window) {
      window = now;
      in_window = 0;
    }
    ++in_window;
  }
  /// Returns whether there were more collisions than the limits permit. If so, the simulation
  /// fails.
  bool is_too_much() const {
    return at_tick > k_events_at_a_tick_max || in_window > k_collisions_in_window_max;
  }
};
/// Returns the text of an error message about too many collisions. `slow_contacts_end`: the scene
/// sets SlowContacts.
std::string words_of_too_much(const CollisionCount& count, bool slow_contacts_end);

/// A body's contact state without touches, collision counts and times. Touches are in a list of
/// TouchRecord (rest_log.h). Counts and times follow from the event itself (World::restore).
struct ContactState {
  RestState rest;
  Supports supports;
};

}  // namespace sleight::physics
