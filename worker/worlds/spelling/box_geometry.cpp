#include "worker/worlds/spelling/box_geometry.h"

#include <algorithm>
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

std::size_t BoxGeometry::moves_to(std::span<const Vec3> offsets_m) const {
  constexpr std::size_t k_looked_at = 8;
  const std::size_t step = std::max<std::size_t>(offsets_m.size() / k_looked_at, 1);
  std::size_t moves = 0;
  for (std::size_t v = 0; v < offsets_m.size(); v += step)
    moves += offsets_m[v] == offsets_m_[v] ? 0 : 1;
  return moves;
}

std::unique_ptr<BoxGeometry> BoxGeometries::take(std::span<const Vec3> offsets_m) {
  const std::scoped_lock lock(mutex_);
  const auto nearest = std::ranges::min_element(
      free_, {}, [&](const auto& geometry) { return geometry->moves_to(offsets_m); });
  if (nearest == free_.end()) return nullptr;
  std::swap(*nearest, free_.back());
  auto geometry = std::move(free_.back());
  free_.pop_back();
  return geometry;
}

BoxGeometries::Loan::~Loan() {
  const std::scoped_lock lock(from_.mutex_);
  from_.free_.push_back(std::move(geometry_));
}

}  // namespace sleight::worlds::spelling
