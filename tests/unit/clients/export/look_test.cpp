// Goal: each shape is at its place in the scene, is closed, and has outward normals. Goals follow
// the table's surface. Method: count the triangles of each shape. Compare the stored normals with
// the triangles' normals. Compare heights and slopes with the surface in common/scene.
#include "clients/export/look.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "clients/plot/scene_colors.h"
#include "common/scene/surface.h"

namespace sleight::gltf {
namespace {

using math::Vec3;
using scene::FeatureKind;
using scene::Shape;

Vec3 back(const Float3& v) {
  return {v[0], -v[2], v[1]};
}

Look look_of_part(scene::Part part, FeatureKind kind = FeatureKind::body,
                  const scene::Variation& own = {}, std::int32_t body = scene::k_none) {
  scene::Scene scene;
  scene.features = {{.name = "thing", .kind = kind, .body = body}};
  scene.parts = {part};
  return look_of(scene, 0, own, {});
}

/// Middle and normal of a triangle. The normal's length is twice the triangle's area.
struct Face {
  Vec3 middle_m;
  Vec3 normal;
};

std::vector<Face> faces_of(const Primitive& primitive) {
  std::vector<Face> faces;
  for (std::size_t i = 0; i + 2 < primitive.corners.size(); i += 3) {
    const Vec3 a = back(primitive.places.at(primitive.corners[i]));
    const Vec3 b = back(primitive.places.at(primitive.corners[i + 1]));
    const Vec3 c = back(primitive.places.at(primitive.corners[i + 2]));
    faces.push_back({Vec3((a + b + c) / 3), math::cross(Vec3(b - a), Vec3(c - a))});
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 normal = back(primitive.normals.at(primitive.corners[i + k]));
      EXPECT_NEAR(math::norm(normal), 1, 1e-6);
      EXPECT_GT(normal.dot(faces.back().normal), 0);
    }
  }
  return faces;
}

/// Returns the volume that the faces enclose, by the divergence theorem.
double volume_m3(const std::vector<Face>& faces) {
  double sum = 0;
  for (const Face& face : faces)
    sum += face.middle_m.dot(face.normal) / 6;
  return sum;
}

TEST(Look, SpheresAndBoxesAreClosedAndSeenFromOutside) {
  const Vec3 place_m{1, 2, 3};
  const Look sphere =
      look_of_part({.shape = Shape::sphere, .size_m = {2, 2, 2}, .position_m = place_m});
  ASSERT_EQ(sphere.size(), 1U);
  const auto faces = faces_of(sphere[0]);
  EXPECT_EQ(faces.size(), 192U);
  for (const Face& face : faces)
    EXPECT_GT((face.middle_m - place_m).dot(face.normal), 0);
  EXPECT_NEAR(volume_m3(faces), 4.0 / 3 * M_PI, 0.5);
  EXPECT_LT(volume_m3(faces), 4.0 / 3 * M_PI);
  for (const Float3& place : sphere[0].places)
    EXPECT_NEAR(math::norm(Vec3(back(place) - place_m)), 1, 1e-6);

  const Look box = look_of_part({.shape = Shape::box,
                                 .size_m = {1, 2, 3},
                                 .position_m = place_m,
                                 .orientation = math::quaternion_of_rotation_vector({1, 2, 1})});
  ASSERT_EQ(box.size(), 1U);
  EXPECT_EQ(faces_of(box[0]).size(), 12U);
  EXPECT_NEAR(volume_m3(faces_of(box[0])), 6, 1e-5);
}

TEST(Look, DiceHavePipsAboveTheirFaces) {
  const Look die = look_of_part({.shape = Shape::die, .size_m = {0.02, 0.02, 0.02}});
  ASSERT_EQ(die.size(), 2U);
  EXPECT_EQ(die[0].material.name, "ivory");
  EXPECT_NEAR(volume_m3(faces_of(die[0])), 8e-6, 1e-11);
  // A pip has ten triangles. The numbers of opposite faces add up to 7. Faces 1, 2, 3 are on +x,
  // +y, +z.
  EXPECT_EQ(die[1].material.name, "ink");
  std::map<std::pair<int, bool>, int> corners;
  for (const Float3& place : die[1].places) {
    const Vec3 at = back(place);
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(at[axis]) <= 0.01) continue;
      EXPECT_NEAR(std::abs(at[axis]), 0.0101, 1e-8);
      ++corners[{axis, at[axis] > 0}];
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ((corners[{axis, true}]), 12 * (axis + 1));
    EXPECT_EQ((corners[{axis, false}]), 12 * (6 - axis));
  }
  EXPECT_EQ(faces_of(die[1]).size(), 210U);
}

TEST(Look, SurfacesHaveTheHeightsAndSlopesOfTheirPoints) {
  scene::Variation own;
  for (std::int32_t j = -2; j <= 3; ++j) {
    for (std::int32_t i = -2; i <= 4; ++i)
      own.points.push_back(
          {.i = i, .j = j, .height_m = 0.01 * ((5 * i * i + 7 * i * j + 3 * j) % 11)});
  }
  constexpr double k_spacing_m = 0.05;
  const scene::Surface surface(own.points, k_spacing_m);
  const Look look = look_of_part({.shape = Shape::surface, .size_m = {1, 1, k_spacing_m}},
                                 FeatureKind::fixed, own);
  ASSERT_EQ(look.size(), 1U);
  EXPECT_TRUE(look[0].material.is_double_sided);
  EXPECT_EQ(faces_of(look[0]).size(), 32 * surface.patches().size());
  for (std::size_t i = 0; i < look[0].places.size(); ++i) {
    const Vec3 at = back(look[0].places[i]);
    constexpr double k_step_m = 1e-6;
    const auto height_m = [&](double x_m, double y_m) {
      // Beyond the rim, the surface has no height.
      const auto found = surface.height_m(x_m, y_m);
      return found ? *found : std::nan("");
    };
    const double inside_x_m = at.x() > 0.07 ? -k_step_m : k_step_m;
    const double inside_y_m = at.y() > 0.02 ? -k_step_m : k_step_m;
    const double here_m = height_m(at.x() + inside_x_m, at.y() + inside_y_m);
    EXPECT_NEAR(at.z(), here_m, 5e-6);  // here_m is one step aside; slopes reach 2
    const double along_x =
        (height_m(at.x() + 2 * inside_x_m, at.y() + inside_y_m) - here_m) / inside_x_m;
    const double along_y =
        (height_m(at.x() + inside_x_m, at.y() + 2 * inside_y_m) - here_m) / inside_y_m;
    const Vec3 normal = math::normalized(Vec3(-along_x, -along_y, 1));
    EXPECT_LT(math::norm(Vec3(back(look[0].normals[i]) - normal)), 1e-3);
  }
  EXPECT_TRUE(look_of_part({.shape = Shape::surface, .size_m = {1, 1, 0}}, FeatureKind::fixed, own)
                  .empty());
}

TEST(Look, GoalsLieOnTheTable) {
  scene::Scene scene;
  scene.features = {{.name = "die"},
                    {.name = "table", .kind = FeatureKind::fixed},
                    {.name = "place", .kind = FeatureKind::wanted, .body = 0},
                    {.name = "anywhere", .kind = FeatureKind::wanted}};
  scene.parts = {{.feature = 0, .shape = Shape::die, .size_m = {0.02, 0.02, 0.02}},
                 {.feature = 1, .shape = Shape::surface, .size_m = {1, 1, 0.1}},
                 {.feature = 2, .shape = Shape::disc, .size_m = {0.06, 0.06, 0}},
                 {.feature = 3, .shape = Shape::box, .size_m = {0.1, 0.1, 0}}};
  scene::Variation own;
  for (std::int32_t j = -3; j <= 4; ++j) {
    for (std::int32_t i = -3; i <= 4; ++i)
      own.points.push_back({.i = i, .j = j, .height_m = 0.02 + 0.01 * i});
  }
  const scene::Surface surface(own.points, 0.1);
  const Look ring = look_of(scene, 2, own, {});
  ASSERT_EQ(ring.size(), 1U);
  EXPECT_EQ(ring[0].material.color, plot::scene_colors::k_ring);
  faces_of(ring[0]);
  for (const Float3& place : ring[0].places) {
    const Vec3 at = back(place);
    EXPECT_NEAR(at.z(), *surface.height_m(at.x(), at.y()) + 0.2e-3, 1e-6);
    EXPECT_LE(std::hypot(at.x(), at.y()), 0.03 + 1e-6);
  }
  const Look tint = look_of(scene, 3, own, {});
  ASSERT_EQ(tint.size(), 1U);
  EXPECT_LT(tint[0].material.color.opacity, 1);
}

TEST(Look, MeshesAreMovedByOffsets) {
  scene::Scene scene;
  scene.features = {{.name = "wall", .kind = FeatureKind::fixed}};
  scene.parts = {{.shape = Shape::mesh, .position_m = {0, 0, 1}, .triangles = 2}};
  scene.vertices = {{.place_m = {0, 0, 0}},
                    {.place_m = {1, 0, 0}},
                    {.place_m = {0, 1, 0}, .offset = 0},
                    {.place_m = {0, 0, 0}, .offset = 7}};
  scene.triangles = {{0, 1, 2}, {0, 1, 3}};
  const std::vector<Vec3> offsets_m{{0, 0, 0.25}};
  const Look look = look_of(scene, 0, {}, offsets_m);
  ASSERT_EQ(look.size(), 1U);
  EXPECT_EQ(look[0].places, (std::vector<Float3>{{0, 1, 0}, {1, 1, 0}, {0, 1.25F, -1}}));
  EXPECT_TRUE(look_of_part({.shape = Shape::sphere, .size_m = {0, 0, 0}}).empty());
}

}  // namespace
}  // namespace sleight::gltf
