#include <algorithm>
#include <array>

#include "tests/scenes/shared/scenes.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics::scenes {
namespace {

Setting thin_gas(std::uint32_t bodies, std::uint64_t seed) {
  return hard_sphere_gas(bodies, 0.1, seed);
}
Setting dense_gas(std::uint32_t bodies, std::uint64_t seed) {
  return hard_sphere_gas(bodies, 0.4, seed);
}

constexpr std::array k_scenes{
    SceneEntry{"boxed_polyhedra", "elastic polyhedra of 42 vertices between six walls",
               &boxed_polyhedra, 64},
    SceneEntry{"boxed_spheres", "elastic spheres between six walls", &boxed_spheres, 64},
    SceneEntry{"bowling", "a ball that rolls at ten pins", &bowling, 11},
    SceneEntry{"bumpy_floor", "spheres and cubes that fall on a random height field", &bumpy_floor,
               40},
    SceneEntry{"cube_drop", "cubes that fall on a floor", &cube_drop, 1},
    SceneEntry{"cube_stack", "cubes above one another", &cube_stack, 3},
    SceneEntry{"gas_dense", "elastic spheres in periodic space, packing 0.4", &dense_gas, 1000},
    SceneEntry{"gas_thin", "elastic spheres in periodic space, packing 0.1", &thin_gas, 1000},
    SceneEntry{"grain_heap", "grains that make a heap", &grain_heap, 100},
    SceneEntry{"hourglass", "grains that fall through a funnel", &hourglass, 100},
    SceneEntry{"marbles", "spheres that slide and roll over slopes, a ridge and a pedestal",
               &marbles, 15},
    SceneEntry{"rain", "spheres of all sorts that fall into a box and bounce", &rain, 20},
    SceneEntry{"round_solids", "cylinders, coins, cones and other round bodies that fall and roll",
               &round_solids, 12},
    SceneEntry{"tray", "spheres and cubes thrown at a tray with a raised rim", &tray, 40},
    SceneEntry{"wall", "bricks at rest, and a ball that hits them", &wall, 26,
               k_at_rest_together_max + 1},
};

}  // namespace

std::span<const SceneEntry> all() {
  return k_scenes;
}

const SceneEntry* find(std::string_view name) {
  const auto found = std::ranges::find(k_scenes, name, &SceneEntry::name);
  return found == k_scenes.end() ? nullptr : &*found;
}

}  // namespace sleight::physics::scenes
