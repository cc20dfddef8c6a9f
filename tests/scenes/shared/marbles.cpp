#include <array>
#include <utility>

#include "common/math/vector.h"
#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"

namespace sleight::physics::scenes {
namespace {

constexpr double k_marble_m = 0.02;
constexpr double k_box_half_width_m = 0.1;

/// Returns the convex hull of a square and of a smaller square above it.
std::shared_ptr<const ConvexPolyhedron> pedestal(const Vec3& centre_m, double half_m,
                                                 double height_m) {
  std::vector<Vec3> corners_m;
  for (const auto& [size_m, z_m] : {std::pair(half_m, 0.0), {0.6 * half_m, height_m}}) {
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
      corners_m.push_back(centre_m + Vec3(x * size_m, y * size_m, z_m));
  }
  return std::make_shared<const ConvexPolyhedron>(convex_hull(corners_m).value());
}

/// Returns a sheet. With growing x, the sheet rises to a ridge, falls into a furrow and rises
/// again. Ridge and furrow run along y.
std::shared_ptr<const TriangleMesh> ridge_and_furrow(double high_m) {
  constexpr std::array<double, 4> k_xs_m{-0.02, 0.02, 0.06, 0.12};
  const std::array<double, 4> zs_m{-0.01, high_m, 0.2 * high_m, 2 * high_m};
  std::vector<Vec3> vertices_m;
  for (std::size_t i = 0; i < k_xs_m.size(); ++i) {
    for (const double y_m : {-0.12, 0.0, 0.12})
      vertices_m.emplace_back(k_xs_m[i], y_m, zs_m[i]);
  }
  std::vector<TriangleCorners> triangles;
  for (std::uint32_t i = 0; i + 1 < k_xs_m.size(); ++i) {
    for (std::uint32_t j = 0; j < 2; ++j) {
      const std::uint32_t at = 3 * i + j;
      triangles.push_back({at, at + 3, at + 4});
      triangles.push_back({at, at + 4, at + 1});
    }
  }
  return std::make_shared<const TriangleMesh>(
      TriangleMesh::make(vertices_m, triangles, MeshClosure::may_be_open).value());
}

}  // namespace

Setting marbles(std::uint32_t bodies, std::uint64_t seed) {
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{.scene = {}, .duration_s = 2};
  Scene& scene = setting.scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.slow = slow_contacts_of(k_marble_m);
  scene.contacts = ContactTable(2);
  constexpr MaterialId k_steel{0};
  constexpr MaterialId k_rubber{1};
  for (const auto& [a, b] :
       {std::pair(k_steel, k_steel), {k_steel, k_rubber}, {k_rubber, k_rubber}}) {
    scene.contacts.set(a, b,
                       {.restitution = between(stream, 0, 0.5),
                        .friction = stream.uniform() < 0.2 ? 0 : between(stream, 0.05, 0.6),
                        .rolling_friction = stream.uniform() < 0.5 ? 0 : between(stream, 0, 0.03)});
  }
  const double lean_x = between(stream, -0.1, 0.1);
  const double lean_y = between(stream, -0.1, 0.1);
  const Vec3 up = math::normalized(Vec3(lean_x, lean_y, 1));
  scene.planes.push_back({.name = "floor", .outside = {.normal = up, .offset_m = 0}});
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      // Walls lean outwards by up to 45 degrees. So walls form valleys with the floor, and corners
      // with each other.
      Vec3 normal(0, 0, between(stream, 0, 1));
      normal[axis] = -side;
      normal = math::normalized(normal);
      Vec3 foot_m = Vec3::Zero();
      foot_m[axis] = side * k_box_half_width_m;
      scene.planes.push_back({.name = std::string(side < 0 ? "low " : "high ") + "xy"[axis],
                              .outside = {.normal = normal, .offset_m = math::dot(normal, foot_m)},
                              .material = k_rubber});
    }
  }
  scene.convexes.push_back({.name = "pedestal",
                            .polyhedron = pedestal({-0.06, 0, -0.02}, 0.025, 0.035),
                            .material = k_rubber});
  scene.meshes.push_back({.name = "ridge",
                          .mesh = ridge_and_furrow(between(stream, 0.005, 0.02)),
                          .material = k_steel});
  for (std::uint32_t i = 0; i < bodies; ++i) {
    const double radius_m = between(stream, 0.3, 0.5) * k_marble_m;
    const Vec3 site_m(0.03 * (i % 5) - 0.06, 0.03 * (i / 5 % 5) - 0.06, 0.05 + 0.03 * (i / 25));
    BodyDescription marble;
    marble.shape = Sphere{.radius_m = radius_m};
    marble.inertia = solid_ball_inertia(1e4 * radius_m * radius_m * radius_m, radius_m);
    marble.material = i % 2 == 0 ? k_steel : k_rubber;
    marble.start = {.pose = {.position_m = site_m + vector_between(stream, -0.004, 0.004)},
                    .twist = {.velocity_mps = vector_between(stream, -0.4, 0.4),
                              .angular_velocity_radps = vector_between(stream, -40, 40)}};
    scene.bodies.push_back(std::move(marble));
  }
  return setting;
}

}  // namespace sleight::physics::scenes
