// Expands the copies of a body: rows, grids and rings.
// Thread safety: pure functions.
#pragma once

#include <string>
#include <vector>

#include "worker/worlds/user_scene/description.h"

namespace sleight::worlds::user_scene {

/// One body of a scene, after copying.
struct Copy {
  std::string name;
  Pose place;
  /// Rotation of this copy relative to the described body; a ring turns its copies. Velocities turn
  /// too.
  Quat turn = Quat::Identity();
};

/// Returns how many bodies a description stands for.
std::size_t count_of(const Copies& copies);
std::vector<Copy> copies_of(const BodyDescription& body);

}  // namespace sleight::worlds::user_scene
