// Builds the simulator's scene from a user's scene description.
//
// Each body becomes one or more objects: copies are expanded, and each object has a name. Moving
// bodies come first, then fixed bodies, in the request's order; so an object's index is its BodyId
// as long as it is a body. Planes, static polyhedra and meshes follow.
//
// Invariants
//   1. Objects have distinct names.
//   2. A static box or hull is a static polyhedron. A static compound of polyhedra is several.
//      Other static solids are fixed bodies.
//   3. The same shape is made once for all copies.
// Thread safety: pure functions and values.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "worker/physics/contact/impacts.h"
#include "worker/physics/event/ids.h"
#include "worker/physics/scene/scene.h"
#include "worker/worlds/user_scene/body_form.h"
#include "worker/worlds/user_scene/description.h"

namespace sleight::worlds::user_scene {

enum class ObjectKind : std::uint8_t { moving, fixed, plane, convex, mesh };

struct Object {
  std::string name;
  ObjectKind kind = ObjectKind::moving;
  std::uint32_t description = 0;  ///< index in SceneDescription::bodies
  Pose place;                     ///< of the shape's frame at the start
  physics::Twist motion{};        ///< of the shape's frame, in the world
  /// A body's frame in the shape's frame. Other objects: identity.
  Pose frame{};
  /// Index of the first of `count` elements in Scene::planes, convexes or meshes.
  std::uint32_t first = 0;
  std::uint32_t count = 1;
};

/// Why a scene can't be built. `body` is an index in SceneDescription::bodies.
struct BuildError {
  std::uint32_t body = 0;
  FormError error;
};

struct BuiltScene {
  physics::Scene scene;
  std::vector<Object> objects;
  std::uint32_t moving = 0;  ///< number of moving bodies
  std::uint32_t bodies = 0;  ///< number of moving and fixed bodies
  // A box around everything at the start, except planes.
  Vec3 low_m = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high_m = -low_m;

  const physics::Inertia& inertia(std::uint32_t body) const { return scene.bodies[body].inertia; }
};

/// REQUIRES: the limits of description.h; names of objects are distinct.
base::Result<BuiltScene, BuildError> build(const SceneDescription& description);

/// One body of a scene, after copying: rows, grids and rings.
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

/// Returns the start of a body's frame.
physics::StartState start_of(const Object& object);

/// Returns the laws of all pairs of materials.
physics::ContactTable contact_table(std::span<const Material> materials,
                                    std::span<const PairLaw> pairs);

/// Returns the law of a pair of materials that has none of its own.
physics::SurfaceLaw mean_law(const physics::SurfaceLaw& a, const physics::SurfaceLaw& b);

/// Returns how far a shape reaches from the origin of the body's frame along a direction in it.
double support_m(const physics::Shape& shape, const Vec3& direction);

/// Tells to which object a feature or piece of the simulator's static geometry belongs, and which
/// objects an impact joins. The numbering is that of static_geometry.h: spheres meet features,
/// other bodies meet pieces, and planes come before convexes and meshes. Const functions may run
/// concurrently.
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
