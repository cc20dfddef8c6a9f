// Records which bodies have hardly moved. A pair of such bodies needs no look if it was once found
// apart.
//
// Idea. Bodies in a heap bounce by micrometres, thousands of times a second. Each bounce changes
// the predictions for some twenty neighbours, although the bounces never reach most of them. So a
// body has a numbered place. The place has a room, which is a distance. The body keeps its place
// while none of its points has moved further than the room. If a pair was once found far enough
// apart (clear_m), it can't collide while both bodies keep their places, however their motions
// change.
//
// Invariants
//   1. A body has a place up to and including the tick `until`. While it has the place, each of its
//      points is within room_m of where the point was when the place got its number.
//   2. Different places have different numbers.
// Thread safety: none.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "worker/physics/event/ids.h"
#include "worker/physics/motion/rotation_bounds.h"

namespace sleight::physics {

/// The numbers of the places of two bodies. 0: no places.
using PlacesOfPair = std::uint64_t;

class NearPlaces {
 public:
  /// A body's pose at a tick, and bounds on its motion after that tick.
  struct Motion {
    Tick begin{};
    Pose pose{};                   ///< for a sphere: any orientation, but always the same one
    double speed_mps = 0;          ///< maximum speed of any point, if the centre moves straight
    double acceleration_mps2 = 0;  ///< of the centre
    bool stays = false;            ///< the body doesn't move at all
  };

  /// Clears all places. From now on, no body gets a place that would last for fewer than `least`
  /// ticks. If `bodies` is 0, places are off.
  void reset(std::size_t bodies, TickCount least) {
    of_body_.assign(bodies, {});
    least_ = least;
    number_ = 0;
  }
  bool enabled() const { return !of_body_.empty(); }

  /// Call when a body of radius `reach_m` begins a motion. The body keeps its place, gets a new one
  /// or loses it.
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

  /// If both bodies keep a place at least until `tick`, returns the pair's places. Otherwise
  /// returns 0.
  PlacesOfPair of(BodyId a, BodyId b, Tick tick) const {
    const Place& first = of_body_[a];
    const Place& second = of_body_[b];
    const bool both =
        first.number != 0 && second.number != 0 && tick <= first.until && tick <= second.until;
    return both ? (PlacesOfPair{first.number} << 32U) | second.number : 0;
  }
  /// Returns the last tick at which both bodies certainly have these places. REQUIRES: both have a
  /// place.
  Tick until(BodyId a, BodyId b) const { return std::min(of_body_[a].until, of_body_[b].until); }
  /// If a look finds the pair further apart than the returned distance, the bodies can't meet while
  /// both keep their places. REQUIRES: both bodies have a place.
  double clear_m(BodyId a, BodyId b) const {
    // Since its place got its number, each body may have come nearer by its room. Each body may
    // still come nearer by twice its room.
    return 2 * (of_body_[a].room_m + of_body_[b].room_m) + k_margin_m;
  }

 private:
  /// A place's room, as a share of the body's reach. The share is so small that most neighbours in
  /// a heap are clear of each other. Affects speed only.
  static constexpr double k_room = 0.01;
  /// Margin for the touch and for rounding.
  static constexpr double k_margin_m = 1e-6;

  struct Place {
    std::uint32_t number = 0;  ///< 0: none
    Tick until{};
    Pose pose{};
    double room_m = 0;
  };

  /// Returns a tick. Up to this tick, no point can move further than `way_m`.
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
