#include "worker/physics/scene/static_geometries.h"

#include <algorithm>

#include "worker/physics/scene/same_bits.h"

namespace sleight::physics {
namespace {

template <class Static>
bool same_owner(const Static& a, const Static& b) {
  return a.name == b.name && a.material == b.material && a.group == b.group;
}

/// Compares everything except moving bodies.
bool same_statics(const Scene& a, const Scene& b) {
  const auto same_plane = [](const StaticPlane& p, const StaticPlane& q) {
    return same_owner(p, q) && same(p.outside.normal, q.outside.normal) &&
           same(p.outside.offset_m, q.outside.offset_m) && p.friction_map == q.friction_map;
  };
  const auto same_convex = [](const StaticConvex& p, const StaticConvex& q) {
    return same_owner(p, q) && p.polyhedron == q.polyhedron;
  };
  const auto same_mesh = [](const StaticMesh& p, const StaticMesh& q) {
    return same_owner(p, q) && p.mesh == q.mesh && same(p.slack_m, q.slack_m);
  };
  return a.filter == b.filter && std::ranges::equal(a.planes, b.planes, same_plane) &&
         std::ranges::equal(a.convexes, b.convexes, same_convex) &&
         std::ranges::equal(a.meshes, b.meshes, same_mesh);
}

}  // namespace

bool same_geometry(const Scene& a, const Scene& b) {
  return moving_kinds(a) == moving_kinds(b) && same_statics(a, b);
}

std::shared_ptr<const StaticGeometry> StaticGeometries::find(const Scene& scene) const {
  const MovingKinds moving = moving_kinds(scene);
  const auto found = std::ranges::find_if(kept_, [&](const Kept& kept) {
    return kept.moving == moving && same_statics(kept.statics, scene);
  });
  if (found == kept_.end()) return nullptr;
  std::rotate(kept_.begin(), found, found + 1);
  return kept_.front().geometry;
}

bool StaticGeometries::has(const Scene& scene) const {
  const std::scoped_lock lock(mutex_);
  return find(scene) != nullptr;
}

std::shared_ptr<const StaticGeometry> StaticGeometries::of(const Scene& scene) const {
  const std::scoped_lock lock(mutex_);
  if (auto kept = find(scene)) return kept;
  Kept made{.moving = moving_kinds(scene),
            .statics = {},
            .geometry = std::make_shared<const StaticGeometry>(scene)};
  made.statics.planes = scene.planes;
  made.statics.convexes = scene.convexes;
  made.statics.meshes = scene.meshes;
  made.statics.filter = scene.filter;
  if (kept_.size() == k_geometries_max) kept_.pop_back();
  return kept_.insert(kept_.begin(), std::move(made))->geometry;
}

std::shared_ptr<const StaticGeometry> geometry_of(const Scene& scene) {
  return scene.geometries ? scene.geometries->of(scene)
                          : std::make_shared<const StaticGeometry>(scene);
}

}  // namespace sleight::physics
