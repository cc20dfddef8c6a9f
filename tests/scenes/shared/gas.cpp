// Scenes without gravity: gases of elastic spheres.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::scenes {
namespace {

BodyDescription unit_sphere(const Vec3& position_m, const Vec3& velocity_mps) {
  return {.name = {},
          .shape = Sphere{.radius_m = 0.5},
          .inertia = solid_ball_inertia(1, 0.5),
          .start = {.pose = {.position_m = position_m}, .twist = {.velocity_mps = velocity_mps}}};
}

/// Returns `count` different sites in random order. Sites form a face-centred cubic lattice in a
/// cube.
std::vector<Vec3> lattice_sites(std::uint32_t count, double length_m, random::Stream& stream) {
  std::uint32_t cells = 1;
  while (4 * cells * cells * cells < count)
    ++cells;
  const double cell_m = length_m / cells;
  std::vector<Vec3> sites;
  for (std::uint32_t x = 0; x < cells; ++x) {
    for (std::uint32_t y = 0; y < cells; ++y) {
      for (std::uint32_t z = 0; z < cells; ++z) {
        const Vec3 corner = cell_m * Vec3(x + 0.25, y + 0.25, z + 0.25);
        const double half_m = 0.5 * cell_m;
        sites.push_back(corner);
        sites.push_back(corner + Vec3(half_m, half_m, 0));
        sites.push_back(corner + Vec3(half_m, 0, half_m));
        sites.push_back(corner + Vec3(0, half_m, half_m));
      }
    }
  }
  for (std::size_t i = sites.size() - 1; i > 0; --i)
    std::swap(sites[i], sites[stream.bits() % (i + 1)]);
  sites.resize(count);
  return sites;
}

}  // namespace

Setting hard_sphere_gas(std::uint32_t bodies, double packing, std::uint64_t seed) {
  CHECK(packing > 0 && packing <= 0.6);
  random::Stream stream = stream_of_scene(seed, 0);
  const double volume_m3 = bodies * (std::numbers::pi / 6) / packing;
  const double length_m = math::pow(volume_m3, 1.0 / 3);
  Setting setting{.scene = {}, .duration_s = 10};
  Scene& scene = setting.scene;
  scene.period_m = {length_m, length_m, length_m};
  const random::Normal normal{.mean = 0, .sd = 1};
  Vec3 drift = Vec3::Zero();
  for (const Vec3& site : lattice_sites(bodies, length_m, stream)) {
    const double x = normal.draw(stream);
    const double y = normal.draw(stream);
    const double z = normal.draw(stream);
    scene.bodies.push_back(unit_sphere(site, {x, y, z}));
    drift += Vec3(x, y, z);
  }
  // Remove the drift of the whole gas.
  for (BodyDescription& body : scene.bodies)
    body.start.twist.velocity_mps -= drift / bodies;
  return setting;
}

Setting boxed_spheres(std::uint32_t bodies, std::uint64_t seed) {
  random::Stream stream = stream_of_scene(seed, 0);
  const double length_m = std::max(1.5, 10.5 * math::pow(bodies / 64.0, 1.0 / 3));
  const double half_m = 0.5 * length_m;
  Setting setting{.scene = {}, .duration_s = 100};
  Scene& scene = setting.scene;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 normal = Vec3::Zero();
      normal[axis] = -side;
      scene.planes.push_back({.name = std::string(side < 0 ? "low " : "high ") + "xyz"[axis],
                              .outside = {.normal = normal, .offset_m = -half_m}});
    }
  }
  while (scene.bodies.size() < bodies) {
    const Vec3 place_m = vector_between(stream, -half_m + 0.52, half_m - 0.52);
    const bool free = std::ranges::none_of(scene.bodies, [&](const BodyDescription& other) {
      return math::norm(other.start.pose.position_m - place_m) < 1.02;
    });
    if (free) scene.bodies.push_back(unit_sphere(place_m, vector_between(stream, -1, 1)));
  }
  return setting;
}

}  // namespace sleight::physics::scenes
