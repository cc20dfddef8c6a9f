// A body in free flight, in the form that collision searches use.
#pragma once

#include <limits>

#include "worker/physics/collision/convex_search.h"
#include "worker/physics/motion/motion_bounds.h"
#include "worker/physics/motion/rotation_bounds.h"
#include "worker/physics/motion/rotation_track.h"
#include "worker/physics/shape/mass_properties.h"

namespace sleight::physics::testing {

struct Flyer {
  BodyShape body;
  FreeFlight flight;

  const ConvexPolyhedron& part() const { return body.parts[0]; }
  double reach_m() const { return part().r_outer_m(); }
  MovingPiece at(Tick tick, const ConvexView& view) const {
    const RotationBounds bounds = rotation_bounds(flight, body.inertia);
    return {.view = &view,
            .radius_m = 0,
            .pose = placed({position_at(flight, tick), orientation_at(flight, body.inertia, tick)}),
            .coordinates_m = coordinates_m_max(flight, tick),
            .velocity_mps = velocity_at(flight, tick),
            .acceleration_mps2 = flight.acceleration_mps2,
            .angular_velocity_radps = angular_velocity_at(flight, body.inertia, tick),
            .turning_acceleration_mps2 = turning_acceleration_mps2_max(bounds, reach_m()),
            .turns_evenly = body.inertia.symmetry == InertiaSymmetry::spherical,
            .reach_m = reach_m()};
  }
};

/// Returns the same piece, but at rest.
inline MovingPiece standing(const MovingPiece& piece) {
  MovingPiece still;
  still.view = piece.view;
  still.pose = piece.pose;
  still.reach_m = std::numeric_limits<double>::infinity();
  return still;
}

/// Returns a ball with the piece's centre and motion. `centre` must have one vertex, the origin.
inline MovingPiece ball_of(const MovingPiece& piece, double radius_m, const ConvexView& centre) {
  MovingPiece ball = piece;
  ball.view = &centre;
  ball.radius_m = radius_m;
  ball.angular_velocity_radps = Vec3::Zero();
  ball.turning_acceleration_mps2 = 0;
  ball.reach_m = 0;
  return ball;
}

}  // namespace sleight::physics::testing
