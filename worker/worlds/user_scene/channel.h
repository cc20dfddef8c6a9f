// Generates the meshes of channels in which marbles run: helices and ramps.
//
// A channel is a half pipe, open above: the lower half of a circle, swept along a middle line. Its
// mesh is a sheet of zero thickness, which bodies meet from both sides.
//   - A helix's middle line begins at (path_radius, 0, 0) and turns about the z axis. It ends
//     `drop` below its beginning.
//   - A ramp's middle line leads from (0, 0, 0) to (length, 0, -drop).
// The circle's plane contains z and is perpendicular to the middle line seen from above. So the
// channel is lowest exactly below its middle line, by the circle's radius.
//
// A channel of n steps and m strips has 2 n m triangles. Thread safety: pure functions.
#pragma once

#include "common/base/result.h"
#include "worker/physics/shape/triangle_mesh.h"
#include "worker/worlds/user_scene/description.h"

namespace sleight::worlds::user_scene {

/// Returns the vertices and triangles of a channel. REQUIRES: the kind is helix or ramp; at least
/// one step and two strips.
struct Channel {
  std::vector<Vec3> points_m;
  std::vector<physics::TriangleCorners> triangles;
};
Channel channel_of(const ShapeSizes& sizes);

}  // namespace sleight::worlds::user_scene
