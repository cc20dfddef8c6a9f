// The list of scenes that tests, benchmarks and viewers share.
//
// Each scene depends only on its size and a seed. Random places and velocities come from the seed's
// streams, so a scene is the same on every machine. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "worker/physics/scene/scene.h"

namespace sleight::physics::scenes {

/// A scene and the duration of its simulation.
struct Setting {
  Scene scene;
  double duration_s = 1;
};

struct SceneEntry {
  std::string_view name;
  std::string_view what;
  Setting (*make)(std::uint32_t bodies, std::uint64_t seed);
  std::uint32_t bodies_default;
  std::uint32_t bodies_max = 5000;
};

/// Returns all scenes, by name in ascending order.
std::span<const SceneEntry> all();
/// Returns the scene with a name, or null.
const SceneEntry* find(std::string_view name);

/// Elastic spheres of diameter 1 m and mass 1 kg in a periodic cube. They start from a lattice.
/// Velocities are normal, with a standard deviation of 1 m/s per axis. REQUIRES: 0 < packing <=
/// 0.6.
Setting hard_sphere_gas(std::uint32_t bodies, double packing, std::uint64_t seed);

/// Elastic spheres of diameter 1 m in a cube of walls. The spheres are as dense as 64 spheres in a
/// cube of 10.5 m. Each velocity component is uniform in [-1, 1] m/s.
Setting boxed_spheres(std::uint32_t bodies, std::uint64_t seed);

/// Spheres bounce under gravity in a box with tilted walls. Sizes, masses, spins and materials are
/// random. Some spheres start later, at another random place if there is no room.
Setting rain(std::uint32_t bodies, std::uint64_t seed);

/// Polyhedra of 42 vertices that approximate a sphere of diameter 1 m (thesis 3.3.1). Polyhedra
/// have random orientations and no initial spin. Otherwise they start like boxed_spheres().
Setting boxed_polyhedra(std::uint32_t bodies, std::uint64_t seed);

/// Grains fall through a funnel onto a slightly peaked floor, one every 0.05 s (thesis 3.3.2). A
/// grain is a cube of 10 mm with perturbed corners. Some values are from other engines' versions of
/// the scene, because the thesis omits them: restitution 0.5, friction 0.3, a box 160 mm square, a
/// hole 50 mm square.
Setting hourglass(std::uint32_t bodies, std::uint64_t seed);

/// Cubes of 20 mm fall side by side on a floor.
Setting cube_drop(std::uint32_t bodies, std::uint64_t seed);
/// Cubes of 20 mm, stacked nearly vertically.
Setting cube_stack(std::uint32_t bodies, std::uint64_t seed);
/// Grains fall from a lattice and form a heap between four walls.
Setting grain_heap(std::uint32_t bodies, std::uint64_t seed);

/// A ball hits the middle of a wall at 5 m/s. The wall's bricks measure 20 x 10 x 10 cm and are at
/// rest. The wall is about four times as wide as high. Every other row has half a brick at both
/// ends. The ball has 30 kg. It is the last body.
Setting wall(std::uint32_t bodies, std::uint64_t seed);

/// Spheres and cubes of some 10 mm fall between four walls onto a random height field. The height
/// field is an open mesh of 288 triangles.
Setting bumpy_floor(std::uint32_t bodies, std::uint64_t seed);
/// The bodies of bumpy_floor() are thrown at a tray with a rim (a closed mesh). Some miss the tray.
Setting tray(std::uint32_t bodies, std::uint64_t seed);

/// Marbles slide and roll on a tilted floor, on a pedestal, and on a sheet that has a ridge and a
/// furrow. Four leaning walls surround them. Restitution, friction and rolling friction are random.
Setting marbles(std::uint32_t bodies, std::uint64_t seed);

/// Cylinders, coins, capsules, cones, rounded boxes, and some balls and cubes. Sizes are one or two
/// centimetres. The bodies fall between four leaning walls on a floor. A block is in the middle.
Setting round_solids(std::uint32_t bodies, std::uint64_t seed);

/// At most ten bowling pins in their usual places. The last body is a ball that rolls towards them.
Setting bowling(std::uint32_t bodies, std::uint64_t seed);

/// Returns the rule for slow contacts of bodies of this size in the earth's gravity. Let v be the
/// speed after a fall by half the size, and t the fall's duration. Bodies separate at speed v/100.
/// A body comes to rest if its speed is below 8v/100 for a time of t/10.
SlowContacts slow_contacts_of(double size_m);

}  // namespace sleight::physics::scenes
