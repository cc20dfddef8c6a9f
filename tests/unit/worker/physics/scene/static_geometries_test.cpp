// Tests that scenes share static geometry exactly if it is the same for both.
#include "worker/physics/scene/static_geometries.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>
#include <vector>

#include "tests/scenes/shared/scenes.h"

namespace sleight::physics {
namespace {

TEST(StaticGeometries, AreSharedByScenesWithTheSameStatics) {
  // Goal: a change on which the geometry depends leads to other geometry; other changes don't.
  const StaticGeometries geometries;
  const Scene first = scenes::tray(4, 1).scene;
  ASSERT_FALSE(geometries.has(first));
  const auto geometry = geometries.of(first);
  ASSERT_TRUE(geometries.has(first));
  const auto is_shared = [&](auto change) {
    Scene scene = first;
    change(scene);
    EXPECT_EQ(geometries.of(first), geometry);
    EXPECT_EQ(same_geometry(first, scene), geometries.has(scene));
    return geometries.of(scene) == geometry;
  };
  const auto radius_m = [](Scene& scene) -> double& {
    return std::get<Sphere>(scene.bodies[0].shape).radius_m;
  };
  EXPECT_TRUE(is_shared([](Scene&) {}));
  EXPECT_TRUE(is_shared([](Scene& scene) { scene.bodies[1].start.pose.position_m.x() += 1; }));
  EXPECT_TRUE(is_shared([](Scene& scene) { scene.gravity_mps2.x() = 1; }));
  EXPECT_TRUE(is_shared([&](Scene& scene) { radius_m(scene) *= 0.99; }));
  EXPECT_FALSE(is_shared([&](Scene& scene) { radius_m(scene) *= 4; }));
  EXPECT_FALSE(is_shared([](Scene& scene) { scene.bodies.resize(1); }));
  EXPECT_FALSE(is_shared([](Scene& scene) { scene.meshes[0].group = {1}; }));
  EXPECT_FALSE(is_shared([](Scene& scene) { scene.filter.set_meet({0}, {0}, false); }));
  EXPECT_FALSE(is_shared([](Scene& scene) { scene.meshes[0].material = {1}; }));
  EXPECT_FALSE(is_shared([](Scene& scene) { scene.meshes[0].name = "other"; }));
  EXPECT_FALSE(is_shared([](Scene& scene) { scene.planes[0].outside.offset_m += 1e-9; }));
  EXPECT_FALSE(is_shared([](Scene& scene) {
    scene.meshes[0].mesh = std::make_shared<const TriangleMesh>(*scene.meshes[0].mesh);
  }));
  EXPECT_FALSE(is_shared([](Scene& scene) { scene.planes[0].outside.normal.x() = -0.0; }));
}

TEST(StaticGeometries, AreBuiltOnceForAllThreads) {
  // Goal: threads that ask at the same time get one object. Method: ask in four threads at once.
  const StaticGeometries geometries;
  const Scene scene = scenes::tray(4, 1).scene;
  std::array<std::shared_ptr<const StaticGeometry>, 4> found;
  {
    std::vector<std::jthread> threads;
    for (auto& one : found)
      threads.emplace_back([&] { one = geometries.of(scene); });
  }
  for (const auto& one : found)
    EXPECT_EQ(one, found[0]);
}

}  // namespace
}  // namespace sleight::physics
