// Random scenes of every kind, small enough for the slow reference.
#pragma once

#include <cstdint>
#include <string>

#include "tests/scenes/shared/scenes.h"

namespace sleight::physics::testing {

struct TestScene {
  std::string name;
  scenes::Setting setting;
};

/// The n-th scene of an endless list of alternating kinds and sizes. No round bodies.
inline TestScene test_scene(std::uint64_t n) {
  const std::uint64_t seed = n / 9 + 1;
  switch (n % 9) {
    case 0: {
      const auto bodies = static_cast<std::uint32_t>(2 + seed * 7 % 60);
      return {"rain " + std::to_string(bodies), scenes::rain(bodies, seed)};
    }
    case 1: {
      const auto bodies = static_cast<std::uint32_t>(1 + seed * 5 % 30);
      TestScene scene{"boxed_spheres " + std::to_string(bodies),
                      scenes::boxed_spheres(bodies, seed)};
      scene.setting.duration_s = 20;
      return scene;
    }
    case 2: {
      // One scene in three has almost the least valid period: ten radii.
      TestScene scene =
          seed % 3 == 0
              ? TestScene{"gas 24", scenes::hard_sphere_gas(24, 0.1, seed)}
              : TestScene{"gas 108", scenes::hard_sphere_gas(108, seed % 2 == 0 ? 0.4 : 0.1, seed)};
      scene.setting.duration_s = 0.5;
      return scene;
    }
    case 3: {
      const auto bodies = static_cast<std::uint32_t>(1 + seed * 3 % 12);
      TestScene scene{"boxed_polyhedra " + std::to_string(bodies),
                      scenes::boxed_polyhedra(bodies, seed)};
      scene.setting.duration_s = 6;
      return scene;
    }
    case 4: {
      const auto bodies = static_cast<std::uint32_t>(1 + seed % 4);
      TestScene scene{"cube_drop " + std::to_string(bodies), scenes::cube_drop(bodies, seed)};
      scene.setting.duration_s = 0.25;
      return scene;
    }
    case 5: {
      const auto bodies = static_cast<std::uint32_t>(1 + seed % 3);
      TestScene scene{"bumpy_floor " + std::to_string(bodies), scenes::bumpy_floor(bodies, seed)};
      scene.setting.duration_s = 0.12;
      return scene;
    }
    case 6: {
      const auto bodies = static_cast<std::uint32_t>(2 + seed * 5 % 11);
      TestScene scene{"tray " + std::to_string(bodies), scenes::tray(bodies, seed)};
      scene.setting.duration_s = 0.2;
      return scene;
    }
    case 7: {
      const auto bodies = static_cast<std::uint32_t>(1 + seed * 3 % 12);
      TestScene scene{"marbles " + std::to_string(bodies), scenes::marbles(bodies, seed)};
      scene.setting.duration_s = 0.6;
      return scene;
    }
    default: {
      const auto bodies = static_cast<std::uint32_t>(2 + seed % 6);
      TestScene scene{"hourglass " + std::to_string(bodies), scenes::hourglass(bodies, seed)};
      scene.setting.duration_s = 0.5;
      return scene;
    }
  }
}

/// Like test_scene(), but one scene in eleven has round bodies or bricks that start at rest.
inline TestScene any_scene(std::uint64_t n) {
  if (n % 11 != 10) return test_scene(n);
  const std::uint64_t seed = n / 11 + 1;
  if (seed % 7 == 0) {
    TestScene scene{"bowling", scenes::bowling(static_cast<std::uint32_t>(2 + seed % 6), seed)};
    scene.setting.duration_s = 0.25;
    return scene;
  }
  if (seed % 7 == 3) {
    const auto bodies = static_cast<std::uint32_t>(3 + seed * 3 % 10);
    TestScene scene{"wall " + std::to_string(bodies), scenes::wall(bodies, seed)};
    scene.setting.duration_s = 0.15;
    return scene;
  }
  const auto bodies = static_cast<std::uint32_t>(1 + seed * 3 % 10);
  TestScene scene{"round_solids " + std::to_string(bodies), scenes::round_solids(bodies, seed)};
  scene.setting.duration_s = 0.3;
  return scene;
}

}  // namespace sleight::physics::testing
