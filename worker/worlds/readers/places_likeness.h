// Compares animations by the places of their bodies, for a world's StateReader.
//
// A likeness is a list of numbers: the number of events, then x, y, z of all bodies at the ticks 0,
// step, 2 step, ... up to the end, and again at the end. The distance of two likenesses is
//   max over bodies and ticks of (distance of the body's two places / the body's diameter)
//     + |difference of events| / max(events of either, 1).
// After the end of the shorter animation, its places are those at its end. Before a body's start,
// its places are NaN and don't count. Thread safety: a value.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "common/math/vector.h"
#include "worker/physics/reuse/recording.h"

namespace sleight::worlds {

/// Returns a body's place at a tick; NaN if it hasn't started.
using PlaceOf = std::function<math::Vec3(std::uint32_t body, physics::Tick tick)>;
/// The places of bodies' centres. REQUIRES: the recording outlives the result.
PlaceOf centres_of(const physics::Recording& recording);

struct PlacesLikeness {
  std::vector<double> diameters_m{};  ///< by body; at least one, all above 0
  physics::TickCount step = 1;        ///< above 0

  /// Returns a likeness. Calls `place_m` for all bodies and ticks.
  std::vector<double> numbers(double events, physics::Tick end, const PlaceOf& place_m) const;
  /// Returns the distance. If it is above `enough`, may return another number above `enough`, which
  /// is faster. REQUIRES: results of numbers().
  double distance(std::span<const double> a, std::span<const double> b,
                  double enough = std::numeric_limits<double>::infinity()) const;
};

}  // namespace sleight::worlds
