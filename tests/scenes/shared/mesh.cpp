// Scenes on static triangle meshes, open and closed.
#include <algorithm>
#include <array>
#include <vector>

#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::scenes {
namespace {

constexpr double k_tray_half_width_m = 0.1;
constexpr double k_cube_m = 0.01;

std::shared_ptr<const TriangleMesh> mesh_of(std::span<const Vec3> vertices_m,
                                            std::span<const TriangleCorners> triangles,
                                            MeshClosure closure) {
  return std::make_shared<const TriangleMesh>(
      TriangleMesh::make(vertices_m, triangles, closure).value());
}

/// The four corners are in anticlockwise order.
void add_square(std::vector<TriangleCorners>& triangles, std::uint32_t a, std::uint32_t b,
                std::uint32_t c, std::uint32_t d) {
  triangles.push_back({a, b, c});
  triangles.push_back({a, c, d});
}

/// Returns a sheet of cells^2 squares. The sheet's centre is on the z axis. Heights are random.
std::shared_ptr<const TriangleMesh> height_field(std::uint32_t cells, double edge_m, double high_m,
                                                 random::Stream& stream) {
  std::vector<Vec3> vertices_m;
  for (std::uint32_t y = 0; y <= cells; ++y) {
    for (std::uint32_t x = 0; x <= cells; ++x) {
      vertices_m.emplace_back((x - 0.5 * cells) * edge_m, (y - 0.5 * cells) * edge_m,
                              between(stream, 0, high_m));
    }
  }
  std::vector<TriangleCorners> triangles;
  for (std::uint32_t y = 0; y < cells; ++y) {
    for (std::uint32_t x = 0; x < cells; ++x) {
      const std::uint32_t at = y * (cells + 1) + x;
      add_square(triangles, at, at + 1, at + cells + 2, at + cells + 1);
    }
  }
  return mesh_of(vertices_m, triangles, MeshClosure::may_be_open);
}

std::shared_ptr<const TriangleMesh> tray_mesh(double half_m, double wall_m, double bottom_m,
                                              double height_m) {
  // The corners of four squares, in this order: outer low, outer high, inner high, inner low.
  const std::array<double, 4> halves_m{half_m, half_m, half_m - wall_m, half_m - wall_m};
  const std::array<double, 4> heights_m{0, height_m, height_m, bottom_m};
  std::vector<Vec3> vertices_m;
  for (std::size_t ring = 0; ring < 4; ++ring) {
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
      vertices_m.emplace_back(x * halves_m[ring], y * halves_m[ring], heights_m[ring]);
  }
  std::vector<TriangleCorners> triangles;
  add_square(triangles, 3, 2, 1, 0);
  add_square(triangles, 12, 13, 14, 15);
  for (std::uint32_t ring = 0; ring < 12; ring += 4) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t next = (k + 1) % 4;
      add_square(triangles, ring + k, ring + next, ring + 4 + next, ring + 4 + k);
    }
  }
  return mesh_of(vertices_m, triangles, MeshClosure::closed);
}

/// Adds spheres and cubes in turn, on a loose lattice. A layer has six by six bodies.
void add_bodies(Scene& scene, std::uint32_t bodies, double lowest_m, double speed_mps,
                random::Stream& stream) {
  BodyShape body =
      in_body_frame(std::vector{cube(k_cube_m).value()}, 2500, InertiaSymmetry::spherical).value();
  const auto solid = std::make_shared<const Compound>(Compound{.parts = std::move(body.parts)});
  for (std::uint32_t i = 0; i < bodies; ++i) {
    const Vec3 site_m(0.025 * (i % 6) - 0.0625, 0.025 * (i / 6 % 6) - 0.0625,
                      lowest_m + 0.025 * (i / 36));
    BodyDescription description;
    if (i % 2 == 0) {
      const double radius_m = between(stream, 0.004, 0.008);
      description.shape = Sphere{.radius_m = radius_m};
      description.inertia =
          solid_ball_inertia(1e7 * radius_m * radius_m * radius_m / 1000, radius_m);
    } else {
      description.shape = solid;
      description.inertia = body.inertia;
    }
    description.start = {.pose = {.position_m = site_m + vector_between(stream, -0.003, 0.003),
                                  .orientation = random::UniformRotation{}.draw(stream)},
                         .twist = {.velocity_mps = vector_between(stream, -speed_mps, speed_mps),
                                   .angular_velocity_radps = vector_between(stream, -10, 10)}};
    scene.bodies.push_back(std::move(description));
  }
}

Scene gravity_scene() {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, {.restitution = 0.5, .friction = 0.4});
  scene.slow = slow_contacts_of(k_cube_m);
  return scene;
}

}  // namespace

Setting bumpy_floor(std::uint32_t bodies, std::uint64_t seed) {
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{.scene = gravity_scene(), .duration_s = 3};
  Scene& scene = setting.scene;
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 normal = Vec3::Zero();
      normal[axis] = -side;
      scene.planes.push_back({.name = std::string(side < 0 ? "low " : "high ") + "xyz"[axis],
                              .outside = {.normal = normal, .offset_m = -k_tray_half_width_m}});
    }
  }
  // The floor extends one cell beyond the walls on each side.
  scene.meshes.push_back({.name = "floor", .mesh = height_field(12, 0.02, 0.01, stream)});
  add_bodies(scene, bodies, 0.03, 0.2, stream);
  return setting;
}

Setting tray(std::uint32_t bodies, std::uint64_t seed) {
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{.scene = gravity_scene(), .duration_s = 3};
  Scene& scene = setting.scene;
  scene.planes.push_back({.name = "table", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  scene.meshes.push_back(
      {.name = "tray", .mesh = tray_mesh(k_tray_half_width_m, 0.02, 0.01, 0.03)});
  add_bodies(scene, bodies, 0.05, 0.8, stream);
  return setting;
}

}  // namespace sleight::physics::scenes
