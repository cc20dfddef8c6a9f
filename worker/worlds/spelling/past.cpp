#include "worker/worlds/spelling/past.h"

#include <limits>
#include <set>

#include "common/base/check.h"

namespace sleight::worlds::spelling {
namespace {

/// More than what counts as a touch, and than rounding.
constexpr float k_margin_m = 1e-5F;

constexpr physics::TouchBox k_nowhere = physics::k_unmeetable;

/// By more than a place.
void grow(physics::TouchBox& box, const Vec3& place_m) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at_m = static_cast<float>(place_m[static_cast<Eigen::Index>(axis)]);
    box.low_m[axis] = std::min(box.low_m[axis], at_m - k_margin_m);
    box.high_m[axis] = std::max(box.high_m[axis], at_m + k_margin_m);
  }
}

}  // namespace

physics::MarbleStories stories_that_hold(const Past& past, const State& state,
                                         const State& candidate) {
  CHECK_EQ(past.stories.size(), candidate.active.size());
  physics::MarbleStories stories = past.stories;
  for (std::size_t ball = 0; ball < stories.size(); ++ball) {
    const bool same = candidate.active[ball] != 0 && state.active[ball] != 0 &&
                      candidate.drops_m[ball] == state.drops_m[ball];
    if (!same) stories[ball] = nullptr;
  }
  return stories;
}

Influence::Influence(const Bins& bins, const physics::StaticGeometry& statics) {
  const auto mesh = bins.unmoved_surface();
  vertices_m_.assign(mesh->vertices_m().begin(), mesh->vertices_m().end());
  std::vector<std::vector<physics::TriangleCorners>> triangles(bins.vertex_count());
  for (std::uint32_t triangle = 0; triangle < mesh->triangles().size(); ++triangle) {
    for (const std::uint32_t corner : mesh->triangles()[triangle]) {
      if (corner >= triangles.size()) continue;
      for (const std::uint32_t edge : mesh->edges_of(triangle)) {
        for (const std::uint32_t beside : mesh->edges()[edge].triangle) {
          if (beside != physics::k_no_triangle)
            triangles[corner].push_back(mesh->triangles()[beside]);
        }
      }
    }
  }
  for (std::uint32_t vertex = 0; vertex < bins.vertex_count(); ++vertex) {
    features_.push_back(statics.features_about(0, vertex));
    std::set<std::uint32_t> corners;
    for (const physics::TriangleCorners& of_one : triangles[vertex])
      corners.insert(of_one.begin(), of_one.end());
    corners_.emplace_back(corners.begin(), corners.end());
  }
}

std::vector<physics::MarbleChange> Influence::changes(std::span<const Vec3> before_m,
                                                      std::span<const Vec3> after_m) const {
  CHECK_EQ(before_m.size(), features_.size());
  CHECK_EQ(after_m.size(), features_.size());
  std::vector<physics::MarbleChange> changes;
  for (std::size_t vertex = 0; vertex < features_.size(); ++vertex) {
    if (before_m[vertex] == after_m[vertex]) continue;
    physics::MarbleChange& change = changes.emplace_back(
        physics::MarbleChange{.features = features_[vertex], .box = k_nowhere});
    for (const std::uint32_t corner : corners_[vertex]) {
      const bool moves = corner < before_m.size();
      for (const std::span<const Vec3>& offsets_m : {before_m, after_m})
        grow(change.box,
             moves ? Vec3(vertices_m_[corner] + offsets_m[corner]) : vertices_m_[corner]);
    }
  }
  return changes;
}

}  // namespace sleight::worlds::spelling
