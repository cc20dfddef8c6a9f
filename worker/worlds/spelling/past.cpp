#include "worker/worlds/spelling/past.h"

#include <limits>

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

Influence::Influence(const Bins& bins, const WorldParameters& world)
    : triangles_(bins.vertex_count()), traps_(bins.vertex_count(), k_nowhere) {
  const auto mesh = bins.unmoved_surface();
  vertices_m_.assign(mesh->vertices_m().begin(), mesh->vertices_m().end());
  for (const physics::TriangleCorners& corners : mesh->triangles()) {
    for (const std::uint32_t corner : corners) {
      if (corner < triangles_.size()) triangles_[corner].push_back(corners);
    }
  }
  // A ball's box reaches from its centre by its radius, so much less does this.
  const double half_m = 0.5 * (world.bin_m + world.partition_m);
  const double inset_m = std::max(0.0, half_m - 0.5 * world.ball_diameter_m);
  for (std::uint32_t row = 0; row < bins.rows(); ++row) {
    for (std::uint32_t column = 0; column < bins.columns(); ++column) {
      for (const std::uint32_t corner : bins.corners({column, row})) {
        if (corner == k_no_vertex) continue;
        Vec3 middle_m = bins.floor_middle_m({column, row});
        middle_m.z() = 0;
        const Vec3 reach_m(inset_m, inset_m, world.partition_height_m);
        grow(traps_[corner], middle_m - reach_m);
        grow(traps_[corner], middle_m + reach_m);
      }
    }
  }
}

ChangedPlaces Influence::changed(std::span<const Vec3> before_m,
                                 std::span<const Vec3> after_m) const {
  CHECK_EQ(before_m.size(), triangles_.size());
  CHECK_EQ(after_m.size(), triangles_.size());
  ChangedPlaces changed;
  for (std::size_t vertex = 0; vertex < triangles_.size(); ++vertex) {
    if (before_m[vertex] == after_m[vertex]) continue;
    changed.traps.push_back(traps_[vertex]);
    for (const physics::TriangleCorners& corners : triangles_[vertex]) {
      physics::TouchBox& box = changed.geometry.emplace_back(k_nowhere);
      for (const std::uint32_t corner : corners) {
        const bool moves = corner < before_m.size();
        for (const std::span<const Vec3>& offsets_m : {before_m, after_m})
          grow(box, moves ? Vec3(vertices_m_[corner] + offsets_m[corner]) : vertices_m_[corner]);
      }
    }
  }
  return changed;
}

}  // namespace sleight::worlds::spelling
