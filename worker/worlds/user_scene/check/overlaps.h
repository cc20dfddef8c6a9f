// Finds all objects of a scene that overlap or touch at their start.
//
// The simulator refuses such a scene, and names only the first pair (SceneError::overlap). A pair
// overlaps if the gap is at most k_touch_m, or if a body's centre of mass is inside a static solid.
// A body that starts at rest may touch what carries it: static objects and other bodies at rest,
// within k_at_rest_gap_m. Moving bodies are compared with each other only if they start at the same
// tick. Pairs that the collision filter separates are skipped.
//
// The depth is the length of the shortest shift that separates two convex pieces. If bodies have
// several pieces, it is the greatest depth of a pair of pieces. A triangle of a mesh is a piece of
// zero thickness. Where a round piece overlaps deeply, a search over directions finds the depth. It
// may stop at a greater depth than the least. Thread safety: a pure function.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/worlds/user_scene/build.h"

namespace sleight::worlds::user_scene {

struct Overlap {
  std::uint32_t a = 0;  ///< index of a moving body in BuiltScene::objects
  std::uint32_t b = 0;  ///< index of another object; above `a`
  double depth_m = 0;   ///< 0: they touch
  /// The centre of mass of `a` is inside the solid `b`. The true depth is at least depth_m.
  bool inside = false;
};

/// Returns the overlaps in ascending order of (a, b). REQUIRES: error_of(scene) has none.
std::vector<Overlap> overlaps_of(const BuiltScene& built);

}  // namespace sleight::worlds::user_scene
