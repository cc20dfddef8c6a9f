// Tells to which object a feature or piece of the simulator's static geometry belongs, and which
// objects an impact joins.
//
// The numbering is that of static_geometry.h: spheres meet features, other bodies meet pieces, and
// planes come before convexes and meshes. Thread safety: const functions may run concurrently.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/physics/contact/impacts.h"
#include "worker/physics/event/ids.h"
#include "worker/worlds/user_scene/build.h"

namespace sleight::worlds::user_scene {

class StaticOwners {
 public:
  explicit StaticOwners(const BuiltScene& built);

  /// Returns an index in BuiltScene::objects. `body`: the body that meets the element.
  std::uint32_t owner(std::uint32_t body, physics::StaticId met) const;
  /// Returns the object that the impact's first body met.
  std::uint32_t met_by(const physics::Impact& impact) const;

 private:
  struct Range {
    std::uint32_t end = 0;
    std::uint32_t object = 0;
  };
  std::vector<Range> features_;  ///< ascending
  std::vector<Range> pieces_;
  std::vector<std::uint32_t> numbered_;  ///< objects, by the number in Impact::higher
  std::vector<bool> is_sphere_;          ///< by body
};

}  // namespace sleight::worlds::user_scene
