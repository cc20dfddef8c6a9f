// Which bodies stay near where they were, so that pairs once seen apart needn't be looked at again?
//
// Idea. In a heap bodies bounce by micrometres, thousands of times a second. Each bounce changes
// what is predicted of some twenty neighbours, most of which are further away than the bounces ever
// reach. So a body has a place, with a number, as long as none of its points is further from where
// it was in that place than its room. A pair that was once seen apart by more than both may use up
// can't collide while both have those places, however their motion changes meanwhile.
//
// Invariants
//   1. While a body has a place, up to and at the tick `until`, each of its points lies within
//      room_m of where it was when the place got its number.
//   2. A number is given once: numbers that are equal mean the same place.
// Thread safety: none.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "worker/physics/event/ids.h"
#include "worker/physics/motion/rotation_bounds.h"

namespace sleight::physics {

/// Two places, or none: 0.
using PlacesOfPair = std::uint64_t;

class NearPlaces {
 public:
  /// A body at a tick, and how fast its points move from then on.
  struct Motion {
    Tick begin{};
    Pose pose{};                   ///< of a sphere: with any orientation, but always the same one
    double speed_mps = 0;          ///< of any point, if the centre goes straight on
    double acceleration_mps2 = 0;  ///< of the centre
    bool stays = false;            ///< it doesn't move at all
  };

  /// No body has a place. Those that would have one for less than `least` get none; with 0 bodies
  /// none ever does.
  void reset(std::size_t bodies, TickCount least) {
    of_body_.assign(bodies, {});
    least_ = least;
    number_ = 0;
  }
  bool enabled() const { return !of_body_.empty(); }

  /// A body of a reach begins a motion; it keeps its place, gets another or has none.
  void began(BodyId body, double reach_m, const Motion& motion) {
    Place& place = of_body_[body];
    const double room_m = k_room * reach_m;
    if (place.number != 0) {
      place.until = until(motion, room_m - moved_m_max(place.pose, motion.pose, reach_m));
      if (place.until - motion.begin >= least_) return;
    }
    place.until = until(motion, room_m);
    if (place.until - motion.begin < least_) {
      place.number = 0;
      return;
    }
    place.number = ++number_;
    place.pose = motion.pose;
    place.room_m = room_m;
  }

  /// The places of a pair at a tick; 0 unless both have one until then.
  PlacesOfPair of(BodyId a, BodyId b, Tick tick) const {
    const Place& first = of_body_[a];
    const Place& second = of_body_[b];
    const bool both =
        first.number != 0 && second.number != 0 && tick <= first.until && tick <= second.until;
    return both ? (PlacesOfPair{first.number} << 32U) | second.number : 0;
  }
  /// How long both have them. REQUIRES: they do.
  Tick until(BodyId a, BodyId b) const { return std::min(of_body_[a].until, of_body_[b].until); }
  /// A pair that is further apart than this, at any time while it has its places, doesn't meet.
  /// REQUIRES: it has places.
  double clear_m(BodyId a, BodyId b) const {
    // Each may have come nearer by its room, and may still do so by twice that.
    return 2 * (of_body_[a].room_m + of_body_[b].room_m) + k_margin_m;
  }

 private:
  /// Of a body's reach. Small enough that it keeps apart what lies side by side in a heap. Speed
  /// only.
  static constexpr double k_room = 0.01;
  /// A margin for the touch and for rounding.
  static constexpr double k_margin_m = 1e-6;

  struct Place {
    std::uint32_t number = 0;  ///< 0: none
    Tick until{};
    Pose pose{};
    double room_m = 0;
  };

  /// When its points have moved so far, at the earliest.
  static Tick until(const Motion& motion, double way_m) {
    if (motion.stays) return k_never;
    if (!(way_m > 0)) return motion.begin;
    const double speed = motion.speed_mps;
    const double root = std::sqrt(speed * speed + 2 * motion.acceleration_mps2 * way_m);
    if (!(speed + root > 0)) return k_never;
    return motion.begin + ticks_before(2 * way_m / (speed + root) * (1 - 0x1p-20));
  }

  std::vector<Place> of_body_;
  TickCount least_ = 0;
  std::uint32_t number_ = 0;
};

}  // namespace sleight::physics
