// A body's contact state beside its segment: the bodies that it touched, the features that it stays
// on.
//
// Thread safety: values.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "worker/physics/simulator/lasting_contact.h"
#include "worker/physics/simulator/resting.h"

namespace sleight::physics {

/// What a sphere in contact stays on.
struct Supports {
  std::array<std::uint32_t, 3> features{};
  std::uint32_t count = 0;
  Tick end = k_never;                   ///< of the segment's accelerations
  std::uint32_t leaves = Stay::k_none;  ///< the one whose region the centre leaves then, if any
  Tick met_body{-k_tick_max.value};     ///< when it last collided with another body
  Vec3 half_way = Vec3::Zero();         ///< of a piece over an edge (lasting_contact.h)
  std::span<const std::uint32_t> all() const { return std::span(features).first(count); }
  bool holds(std::uint32_t feature) const {
    return std::ranges::find(all(), feature) != all().end();
  }
};

/// All contact state but for two parts: the touches lie in a list of TouchRecord (resting.h), and
/// the counts and times of collisions follow from the event itself (World::restore).
struct ContactState {
  Resting::State rest;
  Supports supports;
};

}  // namespace sleight::physics
