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

/// A scene and the time for which it is worth watching.
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

/// Elastic spheres of diameter 1 m and mass 1 kg in a periodic cube. They start from a lattice with
/// normal velocities of standard deviation 1 m/s per axis. REQUIRES: 0 < packing <= 0.6.
Setting hard_sphere_gas(std::uint32_t bodies, double packing, std::uint64_t seed);

/// Elastic spheres of diameter 1 m in a cube of walls, as dense as 64 spheres in a cube of 10.5 m.
/// Each velocity component is uniform in [-1, 1] m/s.
Setting boxed_spheres(std::uint32_t bodies, std::uint64_t seed);

/// Spheres of random sizes, masses, spins and materials that bounce under gravity in a box with
/// tilted walls. Some start later, at another random place if there is no room.
Setting rain(std::uint32_t bodies, std::uint64_t seed);

/// Polyhedra of 42 vertices that approximate a sphere of diameter 1 m (thesis 3.3.1). They have
/// random orientations and no initial spin, and otherwise start like boxed_spheres().
Setting boxed_polyhedra(std::uint32_t bodies, std::uint64_t seed);

/// Grains (cubes of 10 mm with perturbed corners) that fall through a funnel onto a slightly peaked
/// floor, one every 0.05 s (thesis 3.3.2). Other engines' versions of the scene supply the values
/// that the thesis omits: restitution 0.5, friction 0.3, a box 160 mm square, a hole 50 mm square.
Setting hourglass(std::uint32_t bodies, std::uint64_t seed);

/// Cubes of 20 mm that fall side by side on a floor.
Setting cube_drop(std::uint32_t bodies, std::uint64_t seed);
/// Cubes of 20 mm, stacked nearly vertically.
Setting cube_stack(std::uint32_t bodies, std::uint64_t seed);
/// Grains that fall from a lattice between four walls and form a heap.
Setting grain_heap(std::uint32_t bodies, std::uint64_t seed);

/// A wall of bricks of 20 x 10 x 10 cm at rest, about four times as wide as high. Every other row
/// has half a brick at both ends. The last body, a ball of 30 kg, hits the middle at 5 m/s.
Setting wall(std::uint32_t bodies, std::uint64_t seed);

/// Spheres and cubes of some 10 mm that fall between four walls onto a random height field, an open
/// mesh of 288 triangles.
Setting bumpy_floor(std::uint32_t bodies, std::uint64_t seed);
/// The bodies of bumpy_floor(), thrown at a tray with a rim (a closed mesh). Some miss the tray.
Setting tray(std::uint32_t bodies, std::uint64_t seed);

/// Marbles that slide and roll on a tilted floor between four leaning walls, on a pedestal, and on
/// a sheet with a ridge and a furrow. Restitution, friction and rolling friction are random.
Setting marbles(std::uint32_t bodies, std::uint64_t seed);

/// Cylinders, coins, capsules, cones and rounded boxes of one or two centimetres, with some balls
/// and cubes. They fall between four leaning walls on a floor with a block in the middle.
Setting round_solids(std::uint32_t bodies, std::uint64_t seed);

/// At most ten bowling pins in their usual places. The last body is a ball that rolls towards them.
Setting bowling(std::uint32_t bodies, std::uint64_t seed);

/// Returns the rule for slow contacts of bodies of this size in the earth's gravity. Let v be the
/// speed after a fall by half the size, and t the fall's duration. Bodies separate at v/100, and
/// come to rest after a time of t/10 below the speed 8v/100.
SlowContacts slow_contacts_of(double size_m);

}  // namespace sleight::physics::scenes
