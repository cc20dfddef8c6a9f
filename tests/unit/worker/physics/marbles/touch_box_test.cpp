#include "worker/physics/marbles/touch_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/scenes/shared/scenes.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/scene/random_meshes.h"
#include "worker/physics/marbles/near_features.h"
#include "worker/physics/scene/static_geometry.h"

namespace sleight::physics {
namespace {

using testing::vector_between;
using Axes = std::array<float, 3>;

Axes axes_of(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
Axes cross(const Axes& a, const Axes& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
float dot(const Axes& a, const Axes& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}
float across(float part) {
  return std::sqrt(std::max(0.0F, 1 - part * part));
}

/// Least and greatest offset along axis i from the feature to a sphere's centre, in units of the
/// reach.
std::pair<float, float> plain_spread(const SphereFeature& feature,
                                     std::span<const RegionSide> sides, std::size_t i) {
  const Axes along = axes_of(feature.direction);
  if (feature.kind == FeatureKind::face) return {along[i], along[i]};
  if (feature.kind == FeatureKind::vertex) {
    float most = 0;
    float smallest = 0;
    for (const RegionSide& side : sides) {
      most = std::max(most, axes_of(side.space.normal)[i]);
      smallest = std::min(smallest, axes_of(side.space.normal)[i]);
    }
    return {-across(most), across(smallest)};
  }
  std::pair<float, float> spread{-across(along[i]), across(along[i])};
  if (sides.size() != 4) return spread;
  const Axes first = axes_of(sides[2].space.normal);
  const Axes second = axes_of(sides[3].space.normal);
  const Axes ray_a = cross(first, along);
  const Axes ray_b = cross(second, along);
  const float side_a = dot(ray_a, second);
  const float side_b = dot(ray_b, first);
  if (std::fabs(side_a) < 1e-4F || std::fabs(side_b) < 1e-4F) return spread;
  const float a = side_a < 0 ? -ray_a[i] : ray_a[i];
  const float b = side_b < 0 ? -ray_b[i] : ray_b[i];
  if (std::min(first[i], second[i]) < -1e-5F) spread.second = std::max(a, b);
  if (std::max(first[i], second[i]) > 1e-5F) spread.first = std::min(a, b);
  return spread;
}

TouchBox plain_touch_box(const SphereFeature& feature, std::span<const RegionSide> sides,
                         const Box& own, float reach) {
  TouchBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [least, greatest] = plain_spread(feature, sides, i);
    const float pad = static_cast<float>(k_touch_box_pad_m) +
                      0x1p-18F * (std::fabs(own.low_m[i]) + std::fabs(own.high_m[i]) + reach);
    box.low_m[i] = own.low_m[i] + std::min(0.0F, reach * least) - pad;
    box.high_m[i] = own.high_m[i] + std::max(0.0F, reach * greatest) + pad;
  }
  return box;
}

TouchBox fast_touch_box(const SphereFeature& feature, std::span<const RegionSide> sides,
                        const Box& own, float reach) {
  return touch_box_of(feature, sides, extent_of(own, reach), reach);
}

bool same(const TouchBox& a, const TouchBox& b) {
  return a.low_m == b.low_m && a.high_m == b.high_m;
}

TEST(TouchBox, HasTheBitsOfThePlainComputation) {
  // Goal: touch_box_of() computes all axes at once, but returns the same bits as a computation of
  // one axis at a time. Method: compare the boxes of all features of stars, hollows and sheets.
  // These shapes have edges of every kind. Some edges have two equal sides, which leave the edge's
  // wedge undetermined. Count how often a slightly larger reach changes the box.
  std::array<int, 3> kinds{};
  int told_apart = 0;
  for (const std::uint64_t n : property::cases(60)) {
    random::Stream stream({.seed = 41, .purpose = random::Purpose::scene}, n);
    testing::Raw raw = n % 3 == 0 ? testing::sheet(5, 0.2, 0.1, stream)
                                  : testing::star(stream, n % 2 == 0 ? 0 : 0.4);
    if (n % 4 == 0) {
      for (TriangleCorners& corners : raw.triangles)
        std::swap(corners[0], corners[1]);
    }
    Scene scene = scenes::rain(1, 1).scene;
    scene.meshes = {{.name = "it", .mesh = testing::open_mesh(raw)}};
    const StaticGeometry geometry(scene);
    const auto reach = static_cast<float>(0.01 + 0.2 * stream.uniform());
    for (FeatureId f{geometry.plane_count()}; f < geometry.feature_count(); ++f) {
      const SphereFeature& feature = geometry.feature(f);
      std::vector<RegionSide> sides(geometry.sides(feature).begin(), geometry.sides(feature).end());
      // Only an edge with four sides has sides towards both faces. Sometimes make these two sides
      // equal.
      if (feature.kind == FeatureKind::edge && sides.size() == 4 && stream.bits() % 8 == 0)
        sides.back().space.normal = sides[sides.size() - 2].space.normal;
      const Box& own = geometry.feature_box(f);
      const TouchBox plain = plain_touch_box(feature, sides, own, reach);
      ASSERT_TRUE(same(fast_touch_box(feature, sides, own, reach), plain)) << n << ", " << f;
      ++kinds[static_cast<std::size_t>(feature.kind)];
      told_apart += same(fast_touch_box(feature, sides, own, 1.001F * reach), plain) ? 0 : 1;
    }
  }
  if (!property::all_cases()) return;
  for (const int count : kinds)
    EXPECT_GT(count, 1000);
  EXPECT_GT(told_apart, kinds[0] + kinds[1]);
}

TEST(TouchBox, FollowsVerticesWithinTheirSlackAndBeyond) {
  // Goal: after a vertex moves, refreshed features have the touch boxes of the current geometry.
  // The lists of nearby features still contain the refreshed features. Method: move one vertex of a
  // star slightly, or far beyond its slack, and compare the touch boxes with the plain computation.
  // Look up each feature at the middle of its touch box.
  int beyond = 0;
  for (const std::uint64_t n : property::cases(10)) {
    random::Stream stream({.seed = 44, .purpose = random::Purpose::scene}, n);
    const testing::Raw raw = testing::star(stream, 0.2);
    const auto mesh = std::make_shared<TriangleMesh>(
        TriangleMesh::make(raw.vertices_m, raw.triangles, MeshClosure::closed).value());
    Scene scene = scenes::rain(1, 1).scene;
    scene.bodies.resize(1);
    constexpr double k_radius_m = 0.1;
    scene.bodies[0].shape = Sphere{.radius_m = k_radius_m};
    scene.meshes = {{.name = "it", .mesh = mesh, .slack_m = 0.01}};
    StaticGeometry geometry(scene);
    NearFeatures near(geometry, k_radius_m);
    const auto reach = static_cast<float>(k_radius_m + 2 * k_touch_m);
    for (int i = 0; i < 40; ++i) {
      const auto v = static_cast<std::uint32_t>(stream.bits() % raw.vertices_m.size());
      const double way_m = i % 4 == 3 ? 0.2 : 0.009;
      const std::vector<VertexMove> moves{
          {v, raw.vertices_m[v] + vector_between(stream, -way_m, way_m)}};
      if (mesh->move_vertices(moves)) continue;
      const std::uint64_t made = geometry.boxes_made();
      geometry.refresh(0);
      near.refresh();
      beyond += geometry.boxes_made() != made ? 1 : 0;
      for (const FeatureId f : geometry.refreshed()) {
        if (geometry.is_absent(f)) {
          ASSERT_TRUE(same(near.touch_boxes()[f], k_unmeetable)) << n << ", " << i << ", " << f;
          continue;
        }
        const SphereFeature& feature = geometry.feature(f);
        const TouchBox plain =
            plain_touch_box(feature, geometry.sides(feature), geometry.feature_box(f), reach);
        ASSERT_TRUE(same(near.touch_boxes()[f], plain)) << n << ", " << i << ", " << f;
        Vec3 middle_m;
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          middle_m[axis] = 0.5 * (double{plain.low_m[a]} + double{plain.high_m[a]});
        }
        const NearFeatures::Cell cell = near.cell_at(Four::of(middle_m));
        const auto list = feature.kind == FeatureKind::face ? cell.faces : cell.corners;
        ASSERT_TRUE(std::ranges::binary_search(list, f)) << n << ", " << i << ", " << f;
      }
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(beyond, 50);
}

}  // namespace
}  // namespace sleight::physics
