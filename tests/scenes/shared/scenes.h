// The scenes that tests, benchmarks and viewers share: one list.
//
// Each is a function of its size and a seed. Random places and velocities are drawn from streams of
// the seed, so a scene is the same on every machine.
// Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "worker/physics/scene/scene.h"

namespace sleight::physics::scenes {

/// A scene and how long it is worth watching.
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

/// All scenes of the list, by name in ascending order.
std::span<const SceneEntry> all();
/// Null if there is none of this name.
const SceneEntry* find(std::string_view name);

/// Elastic spheres of diameter 1 m and mass 1 kg in a periodic cube, started from a lattice with
/// normal velocities of standard deviation 1 m/s per axis. REQUIRES: 0 < packing <= 0.6.
Setting hard_sphere_gas(std::uint32_t bodies, double packing, std::uint64_t seed);

/// Elastic spheres of diameter 1 m in a cube of walls, at the density of 64 in a cube of 10.5 m;
/// each component of velocity uniform in [-1, 1] m/s.
Setting boxed_spheres(std::uint32_t bodies, std::uint64_t seed);

/// Spheres of random sizes, masses, spins and materials that bounce under gravity in a box whose
/// walls are tilted; some start later, and draw their place again where there is no room.
Setting rain(std::uint32_t bodies, std::uint64_t seed);

/// Thesis 3.3.1: polyhedra of 42 vertices that approximate a sphere of diameter 1 m, otherwise as
/// boxed_spheres, with random orientations and no spin at first.
Setting boxed_polyhedra(std::uint32_t bodies, std::uint64_t seed);

/// Thesis 3.3.2: grains, cubes of 10 mm with perturbed corners, fall one each 0.05 s through a
/// funnel onto a slightly peaked floor. What the thesis leaves open is as in other engines' version
/// of the scene: restitution 0.5, friction 0.3, a box 160 mm square, a hole 50 mm square.
Setting hourglass(std::uint32_t bodies, std::uint64_t seed);

/// Cubes of 20 mm that fall on a floor side by side.
Setting cube_drop(std::uint32_t bodies, std::uint64_t seed);
/// Cubes of 20 mm nearly above one another.
Setting cube_stack(std::uint32_t bodies, std::uint64_t seed);
/// Grains that fall from a lattice between four walls and make a heap.
Setting grain_heap(std::uint32_t bodies, std::uint64_t seed);

/// A wall of bricks of 20 x 10 x 10 cm at rest, about four times as wide as high, every other row
/// of which begins and ends with half a brick, and a ball of 30 kg that hits its middle at 5 m/s:
/// the last body.
Setting wall(std::uint32_t bodies, std::uint64_t seed);

/// Spheres and cubes of some 10 mm that fall between four walls on a random height field, an open
/// mesh of 288 triangles.
Setting bumpy_floor(std::uint32_t bodies, std::uint64_t seed);
/// The same bodies, thrown at a tray with a raised rim, a closed mesh; some miss it and fall on the
/// table beside it.
Setting tray(std::uint32_t bodies, std::uint64_t seed);

/// Marbles that slide and roll: a tilted floor between four leaning walls, a pedestal, and a sheet
/// with a ridge and a furrow. Restitution, friction and rolling friction are drawn.
Setting marbles(std::uint32_t bodies, std::uint64_t seed);

/// Cylinders, coins, capsules, cones and rounded boxes, and some balls and cubes, of one or two
/// centimetres, that fall between four leaning walls on a floor with a block in the middle.
Setting round_solids(std::uint32_t bodies, std::uint64_t seed);

/// Ten bowling pins that stand as in the sport, and a ball that rolls at them: the last body. With
/// fewer bodies, fewer pins.
Setting bowling(std::uint32_t bodies, std::uint64_t seed);

/// What ends slow contacts of bodies of a size in the earth's gravity: separation at 1/100 and rest
/// below 8/100 of the speed that a body has after falling half its size, for a tenth of the time
/// that it takes to fall so far.
SlowContacts slow_contacts_of(double size_m);

}  // namespace sleight::physics::scenes
