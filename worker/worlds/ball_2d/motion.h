// The 2D ball's simulation (thesis 2.4.1): closed-form hops on a table whose normal differs from
// collision to collision.
//
// Frame: x to the right, z up. The origin is the ball's centre when the ball touches the table
// below its start. The ball falls from (0, drop height). Each collision reflects the ball about
// that collision's normal, with the normal component scaled by the restitution. There is one
// collision per normal, and the next collision is the landing. There is no spin, as in the thesis.
//
// The thesis leaves two cases open. A table only pushes, so a ball that already moves away from the
// tilted table keeps its velocity. A ball that doesn't leave the table (vertical velocity not above
// zero after a collision) collides again at once, in the same place, with the next normal.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/vector.h"
#include "worker/worlds/ball_2d/parameters.h"

namespace sleight::worlds::ball_2d {

/// The tilt of each collision's normal from the vertical, positive towards +x. Only the first
/// WorldParameters::collisions entries are used; the others are zero.
using NormalAngles = std::array<double, k_collisions_max>;

/// One parabolic hop, from the start or a collision to the next collision.
struct Flight {
  double start_s = 0;
  double duration_s = 0;
  math::Vec2 position_m{0, 0};    ///< centre at the start of the hop
  math::Vec2 velocity_mps{0, 0};  ///< velocity just after the collision that began the hop
};

struct Landing {
  double x_m = 0;
  double time_s = 0;
};

/// All hops of a throw: flights[0] is the drop, flights[i] follows collision i.
struct Motion {
  std::vector<Flight> flights;  ///< collisions + 1
  Landing landing;
};

/// A pure function with the same bits on every machine. REQUIRES: finite angles.
Landing simulate_landing(const WorldParameters& world, const NormalAngles& normals);

Motion simulate_motion(const WorldParameters& world, const NormalAngles& normals);

/// Returns the velocity after a collision with a fixed surface of the given unit normal.
math::Vec2 reflected(const math::Vec2& velocity, const math::Vec2& normal, double restitution);

}  // namespace sleight::worlds::ball_2d
