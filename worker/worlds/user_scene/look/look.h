// Describes how a user's scene looks (common/scene) and moves (common/motion), for archives and
// viewers.
//
// Each object is one feature, in the objects' order and with their names. Moving bodies have the
// kind `body`; their parts are in the shape's frame (description.h), so archived motions must show
// this frame. All other objects have the kind `fixed`.
//
//   - Spheres and boxes are parts of these shapes, also in compounds.
//   - A plane is a ground, drawn below the middle of all other things and larger than these.
//   - A mesh, helix or ramp has all its triangles. A sheet has each twice, for both sides.
//   - Other solids of a moving body share k_body_triangles_max triangles. A pin, capsule, cylinder,
//     cone or rounded box is drawn as rings about z. A hull with too many triangles is the hull of
//     its furthest points in some directions. If a part's share is too small, the part is a box of
//     the same volume.
//   - A hull of a fixed object isn't simplified.
// All copies share their triangles. Copies of a moving body are twins.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "common/motion/segment.h"
#include "common/scene/scene.h"
#include "worker/physics/reuse/recording.h"
#include "worker/worlds/user_scene/parameters.h"

namespace sleight::worlds::user_scene {

/// Maximum triangles of a moving body in all its parts.
inline constexpr std::uint32_t k_body_triangles_max = 200;

/// Returns the scene's look. `low_m` and `high_m` bound all objects but planes at the start; the
/// caller adds the motion. A box that a constraint asks to show a face is drawn as a die.
scene::Scene look_of(const Parameters& parameters);

/// Returns the motion of the shapes' frames (description.h). Features are numbered as the objects
/// are. REQUIRES: the recording is of built.scene.
std::vector<motion::Segment> segments_of(const BuiltScene& built,
                                         const physics::Recording& recording);

}  // namespace sleight::worlds::user_scene
