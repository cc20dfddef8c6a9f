#include "worker/worlds/user_scene/look/look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sleight::worlds::user_scene {
namespace {

/// Each solid twice as a moving and twice as a fixed body, then a ball, a floor and a sheet.
SceneDescription every_shape() {
  using enum ShapeKind;
  const Pose tilted{.position_m = {0, 0, 0.02}, .orientation = Quat(0.8, 0, 0.6, 0)};
  const ShapeSizes can{.kind = cylinder, .radius_m = 0.01, .length_m = 0.1, .edge_m = 0.001};
  const ShapeSizes pill{.kind = capsule, .radius_m = 0.015, .length_m = 0.08};
  const ShapeSizes brick{.kind = box, .size_m = {0.01, 0.02, 0.03}};
  const ShapeSizes cap{.kind = cone, .radius_m = 0.02, .length_m = 0.04, .edge_m = 0.001};
  const ShapeSizes soap{.kind = rounded_box, .edge_m = 0.004, .size_m = {0.02, 0.03, 0.04}};
  ShapeSizes gem{.kind = hull};  // with more corners than its triangles can show
  for (int i = 0; i < 500; ++i)
    gem.points_m.push_back(math::normalized(Vec3(std::sin(i), std::sin(0.7 * i), std::cos(3 * i))));
  SceneDescription scene;
  scene.materials.emplace_back();
  scene.groups = {"all"};
  const std::vector<ShapeSizes> solids{can, pill, brick, cap, soap, gem, {.kind = pin}};
  for (std::size_t i = 0; i < 18; ++i) {
    BodyDescription& body = scene.bodies.emplace_back();
    body.name = std::to_string(i);
    body.sizes = i < 14 ? solids[i / 2] : ShapeSizes{.kind = compound};
    if (i >= 14) body.parts = {{can}, {pill, tilted}, {brick}};
    if (i >= 16) body.parts.resize(k_parts_max, {pill});  // too many for meshes
    body.is_static = i % 2 == 1;
    body.place = tilted;
    body.copies = {.kind = CopyKind::row, .count = {2, 1, 1}, .step_m = {8, 0, 0}};
  }
  scene.bodies.push_back({.name = "ball", .sizes = {.kind = sphere, .radius_m = 20}});
  scene.bodies.push_back({.name = "floor", .sizes = {.kind = plane}});
  scene.bodies.push_back({.name = "sheet", .sizes = {.kind = mesh, .triangles = {{0, 1, 2}}}});
  scene.bodies.back().sizes.points_m = {{-30, -30, -30}, {0, -30, -30}, {0, 0, 0}};
  return scene;
}

TEST(Look, ShowsEveryShape) {
  // Goal: moving bodies are cheap to draw, copies are twins, and each solid is shown where it is
  // and as large as it is. Method: compare drawn volumes and their centres with the simulator's.
  const SceneDescription description = every_shape();
  const BuiltScene built = build(description).value();
  const scene::Scene scene = look_of({.scene = description,
                                      .built = std::make_shared<const BuiltScene>(built),
                                      .uncertain = {},
                                      .constraints = {}});
  EXPECT_EQ(scene::fault_of(scene), "");
  std::vector<Vec3> points_m;
  std::ranges::transform(scene.vertices, std::back_inserter(points_m), &scene::Vertex::place_m);
  for (std::uint32_t i = 0; i < built.objects.size(); ++i) {
    const BodyDescription& body = description.bodies[built.objects[i].description];
    if (body.sizes.kind >= ShapeKind::plane) continue;
    const double expected_m3 = body_form(body.sizes, body.parts, 1).value().volume_m3;
    SCOPED_TRACE(built.objects[i].name);
    const Pose frame = i < built.moving ? built.objects[i].place : Pose{};
    double volume_m3 = 0;
    Vec3 moment_m4 = Vec3::Zero();
    std::uint32_t triangles = 0;
    for (const scene::Part& part : scene.parts) {
      if (part.feature != i) continue;
      const Pose pose = composed(frame, {part.position_m, part.orientation});
      const auto add = [&](double part_m3, const Vec3& middle_m) {
        volume_m3 += part_m3;
        moment_m4 += part_m3 * composed(pose, {middle_m}).position_m;
      };
      add((part.shape == scene::Shape::sphere ? M_PI / 6 : 1) * part.size_m.prod(), {0, 0, 0});
      const auto own = std::span(scene.triangles).subspan(part.first_triangle, part.triangles);
      EXPECT_TRUE(physics::TriangleMesh::make(points_m, own, physics::MeshClosure::closed).ok());
      triangles += part.triangles;
      for (const auto& [a, b, c] : own)
        add(math::dot(points_m[a], math::cross(points_m[b], points_m[c])) / 6,
            (points_m[a] + points_m[b] + points_m[c]) / 4);
    }
    EXPECT_NEAR(volume_m3 / expected_m3, 1, 0.1);
    EXPECT_EQ(scene.features[i].twin_of, i < built.moving ? i / 2 * 2 : i);
    EXPECT_TRUE(triangles <= k_body_triangles_max || i >= built.moving) << triangles;
    if (i >= built.bodies) continue;
    const Vec3 off_m = moment_m4 / volume_m3 - built.scene.bodies[i].start.pose.position_m;
    EXPECT_LT(math::norm(off_m), 0.03 * std::cbrt(volume_m3));
  }
  // The view is the range of all things, and the ground is larger.
  EXPECT_EQ(scene.low_m, Vec3(-30, -30, -30));
  EXPECT_EQ(scene.high_m, Vec3(20, 20, 20));
  const auto ground = std::ranges::find(scene.parts, scene::Shape::ground, &scene::Part::shape);
  EXPECT_EQ(ground->position_m, Vec3(-5, -5, 0));
  EXPECT_GT(ground->size_m.x(), 50);
}

}  // namespace
}  // namespace sleight::worlds::user_scene
