// The 2D ball's simulation (thesis 2.4.1): closed-form hops on a table. The table's normal differs
// from collision to collision.
//
// Frame: x to the right, z up. The origin is the ball's centre when the ball touches the table
// below its start. The ball falls from (0, drop height). Each collision has a normal. The collision
// reflects the ball's velocity about this normal, and scales the normal component by the
// restitution. After one collision per normal, the next collision is the landing. There is no spin,
// as in the thesis.
//
// The thesis leaves two cases open. A table only pushes, so a ball that already moves away from the
// tilted table keeps its velocity. If the vertical velocity after a collision isn't above zero, the
// ball doesn't leave the table: it collides again at once, in the same place, with the next normal.
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

/// One parabolic hop. A hop begins at the start or at a collision, and ends at the next collision.
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

/// A pure function. It yields the same bits on every machine. REQUIRES: finite angles.
Landing simulate_landing(const WorldParameters& world, const NormalAngles& normals);

Motion simulate_motion(const WorldParameters& world, const NormalAngles& normals);

/// Returns the velocity after a collision with a fixed surface. `normal` has length 1.
math::Vec2 reflected(const math::Vec2& velocity, const math::Vec2& normal, double restitution);

}  // namespace sleight::worlds::ball_2d
