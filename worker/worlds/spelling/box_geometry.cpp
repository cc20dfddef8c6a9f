#include "worker/worlds/spelling/box_geometry.h"

#include <utility>

#include "common/base/check.h"

namespace sleight::worlds::spelling {

BoxGeometry::BoxGeometry(const physics::Scene& with_bodies,
                         std::shared_ptr<physics::TriangleMesh> mesh, std::uint32_t vertices)
    : mesh_(std::move(mesh)),
      statics_(std::make_unique<physics::StaticGeometry>(with_bodies)),
      near_(*statics_, std::get<physics::Sphere>(with_bodies.bodies.front().shape).radius_m),
      offsets_m_(vertices, Vec3::Zero()) {
  moves_.reserve(vertices);
}

bool BoxGeometry::move_to(const Bins& bins, std::span<const Vec3> offsets_m) {
  CHECK_EQ(offsets_m.size(), offsets_m_.size());
  moves_.clear();
  for (std::uint32_t v = 0; v < offsets_m.size(); ++v) {
    if (offsets_m[v] != offsets_m_[v])
      moves_.push_back({.vertex = v, .position_m = bins.vertices_m()[v] + offsets_m[v]});
  }
  if (moves_.empty()) return true;
  if (mesh_->move_vertices(moves_)) return false;
  offsets_m_.assign(offsets_m.begin(), offsets_m.end());
  statics_->refresh(0);
  near_.refresh();
  return true;
}

std::unique_ptr<BoxGeometry> BoxGeometries::take() {
  const std::scoped_lock lock(mutex_);
  if (free_.empty()) return nullptr;
  auto geometry = std::move(free_.back());
  free_.pop_back();
  return geometry;
}

BoxGeometries::Loan::~Loan() {
  const std::scoped_lock lock(from_.mutex_);
  from_.free_.push_back(std::move(geometry_));
}

}  // namespace sleight::worlds::spelling
