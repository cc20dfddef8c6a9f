// A request for a user's scene: the scene, what is uncertain in it, and how it must end.
// Thread safety: values.
#pragma once

#include <memory>
#include <vector>

#include "worker/worlds/user_scene/build.h"
#include "worker/worlds/user_scene/constraints.h"
#include "worker/worlds/user_scene/quantities.h"

namespace sleight::worlds::user_scene {

struct Parameters {
  SceneDescription scene;
  /// The scene without uncertainty. Static geometry is shared by all simulations.
  std::shared_ptr<const BuiltScene> built;
  std::vector<Uncertain> uncertain;
  std::vector<Constraint> constraints;

  /// Returns the description of an object. REQUIRES: `built`.
  const BodyDescription& described(std::uint32_t object) const {
    return scene.bodies[built->objects[object].description];
  }
};

}  // namespace sleight::worlds::user_scene
