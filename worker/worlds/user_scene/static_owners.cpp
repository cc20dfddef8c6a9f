#include "worker/worlds/user_scene/static_owners.h"

#include <algorithm>
#include <variant>

#include "common/base/check.h"
#include "worker/physics/event/event.h"
#include "worker/physics/scene/static_regions.h"

namespace sleight::worlds::user_scene {
namespace {

/// A sheet's triangles are two features each.
std::size_t faces_of(const physics::TriangleMesh& mesh) {
  return (physics::is_closed(mesh) ? 1 : 2) * mesh.triangles().size();
}

}  // namespace

StaticOwners::StaticOwners(const BuiltScene& built) {
  for (const physics::BodyDescription& body : built.scene.bodies)
    is_sphere_.push_back(std::holds_alternative<physics::Sphere>(body.shape));
  const auto extend = [](std::vector<Range>& ranges, std::size_t count, std::uint32_t object) {
    const std::uint32_t begin = ranges.empty() ? 0 : ranges.back().end;
    ranges.push_back({begin + static_cast<std::uint32_t>(count), object});
  };
  for (std::uint32_t object = built.bodies; object < built.objects.size(); ++object) {
    const Object& one = built.objects[object];
    for (std::uint32_t i = one.first; i < one.first + one.count; ++i) {
      numbered_.push_back(object);
      if (one.kind == ObjectKind::mesh) {
        const physics::TriangleMesh& mesh = *built.scene.meshes[i].mesh;
        extend(features_, faces_of(mesh) + mesh.edges().size() + mesh.vertices_m().size(), object);
        extend(pieces_, mesh.triangles().size(), object);
        continue;
      }
      std::size_t features = 1;
      if (one.kind == ObjectKind::convex) {
        const physics::ConvexPolyhedron& hull = *built.scene.convexes[i].polyhedron;
        features = hull.faces().size() + hull.edges().size() + hull.vertices_m().size();
      }
      extend(features_, features, object);
      extend(pieces_, 1, object);
    }
  }
}

std::uint32_t StaticOwners::owner(std::uint32_t body, physics::StaticId met) const {
  const std::vector<Range>& ranges = is_sphere_[body] ? features_ : pieces_;
  const auto at = std::ranges::upper_bound(ranges, met.value, {}, &Range::end);
  CHECK(at != ranges.end());
  return at->object;
}

std::uint32_t StaticOwners::met_by(const physics::Impact& impact) const {
  const bool is_static = (impact.higher & physics::k_static) != 0;
  return is_static ? numbered_[impact.higher & ~physics::k_static] : impact.higher;
}

}  // namespace sleight::worlds::user_scene
