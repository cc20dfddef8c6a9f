// Scenes of convex polyhedra: the thesis's two experiments (3.3), small piles, and a wall.
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::scenes {
namespace {

/// A shape that bodies can share, and its inertia.
struct Solid {
  std::shared_ptr<const Compound> shape;
  Inertia inertia;
};

Solid solid_of(ConvexPolyhedron polyhedron, double density_kgpm3, InertiaSymmetry symmetry) {
  BodyShape body =
      in_body_frame(std::vector{std::move(polyhedron)}, density_kgpm3, symmetry).value();
  return {.shape = std::make_shared<const Compound>(Compound{.parts = std::move(body.parts)}),
          .inertia = body.inertia};
}

Solid cube_of(double side_m) {
  return solid_of(cube(side_m).value(), 2500, InertiaSymmetry::spherical);
}

/// Returns a cube with moved corners. Each corner is moved by up to a tenth of the side per axis.
Solid grain_of(double side_m, random::Stream& stream) {
  std::vector<Vec3> corners_m;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 place((corner & 1) != 0 ? 0.5 : -0.5, (corner & 2) != 0 ? 0.5 : -0.5,
                     (corner & 4) != 0 ? 0.5 : -0.5);
    corners_m.push_back(side_m * (place + vector_between(stream, -0.1, 0.1)));
  }
  return solid_of(convex_hull(corners_m).value(), 2500, InertiaSymmetry::general);
}

BodyDescription body_of(const Solid& solid, std::string name, const Pose& pose) {
  return {.name = std::move(name),
          .shape = solid.shape,
          .inertia = solid.inertia,
          .start = {.pose = pose, .twist = {}}};
}

StaticConvex static_hull(std::string name, std::span<const Vec3> points_m) {
  return {.name = std::move(name),
          .polyhedron = std::make_shared<const ConvexPolyhedron>(convex_hull(points_m).value())};
}

/// Returns one of the four slabs of the thesis's funnel, turned by k quarter turns about z. A
/// slab's upper face runs from the hole to the walls.
StaticConvex funnel_slab(double half_width_m, int k) {
  constexpr double k_side_m = 0.01;
  const Vec3 hole = k_side_m * Vec3(2.5, 0, 15);
  const Vec3 rim = k_side_m * Vec3(9, 0, 23);
  const Vec3 along = rim - hole;
  const Vec3 upward = math::normalized(Vec3(-along.z(), 0, along.x()));
  std::vector<Vec3> points_m;
  for (const Vec3& end : {hole, rim}) {
    for (const double depth : {0.0, 0.8}) {
      for (const double side : {-1.0, 1.0}) {
        const Vec3 p = end - depth * k_side_m * upward + Vec3(0, side * (half_width_m + 0.005), 0);
        switch (k) {
          case 0:
            points_m.push_back(p);
            break;
          case 1:
            points_m.emplace_back(-p.y(), p.x(), p.z());
            break;
          case 2:
            points_m.emplace_back(-p.x(), -p.y(), p.z());
            break;
          default:
            points_m.emplace_back(p.y(), -p.x(), p.z());
            break;
        }
      }
    }
  }
  return static_hull("funnel", points_m);
}

void add_walls(Scene& scene, double half_m, int axes) {
  for (int axis = 0; axis < axes; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 normal = Vec3::Zero();
      normal[axis] = -side;
      scene.planes.push_back({.name = std::string(side < 0 ? "low " : "high ") + "xyz"[axis],
                              .outside = {.normal = normal, .offset_m = -half_m}});
    }
  }
}

/// Returns a scene with gravity and a floor at height 0. `slow` is the scene's rule for slow
/// contacts.
Scene floor_scene(const SlowContacts& slow, const SurfaceLaw& law) {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -k_gravity_mps2};
  scene.contacts = ContactTable(1, law);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  scene.slow = slow;
  return scene;
}

SlowContacts slow_contacts_of_heaps(double size_m) {
  return coarse_slow_contacts_of(size_m, k_gravity_mps2);
}

}  // namespace

SlowContacts slow_contacts_of(double size_m) {
  return physics::slow_contacts_of(size_m, k_gravity_mps2);
}

Setting boxed_polyhedra(std::uint32_t bodies, std::uint64_t seed) {
  random::Stream stream = stream_of_scene(seed, 0);
  const double half_m = 0.5 * std::max(1.5, 10.5 * math::pow(bodies / 64.0, 1.0 / 3));
  Setting setting{.scene = {}, .duration_s = 100};
  Scene& scene = setting.scene;
  add_walls(scene, half_m, 3);
  Solid solid = solid_of(icosphere(0.5, 1).value(), 1, InertiaSymmetry::spherical);
  const double scale = 1 / solid.inertia.mass_kg;  // to 1 kg
  solid.inertia.mass_kg = 1;
  solid.inertia.principal_kgm2 *= scale;
  while (scene.bodies.size() < bodies) {
    const Vec3 place_m = vector_between(stream, -half_m + 0.52, half_m - 0.52);
    const bool free = std::ranges::none_of(scene.bodies, [&](const BodyDescription& other) {
      return math::norm(other.start.pose.position_m - place_m) < 1.02;
    });
    if (!free) continue;
    BodyDescription body = body_of(
        solid, {}, {.position_m = place_m, .orientation = random::UniformRotation{}.draw(stream)});
    body.start.twist.velocity_mps = vector_between(stream, -1, 1);
    scene.bodies.push_back(std::move(body));
  }
  return setting;
}

Setting hourglass(std::uint32_t bodies, std::uint64_t seed) {
  constexpr double k_side_m = 0.01;
  constexpr double k_half_width_m = 0.08;
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{.scene = {}, .duration_s = 0.05 * bodies + 5};
  Scene& scene = setting.scene;
  scene.gravity_mps2 = {0, 0, -k_gravity_mps2};
  scene.contacts = ContactTable(1, {.restitution = 0.5, .friction = 0.3});
  scene.slow = slow_contacts_of_heaps(k_side_m);
  add_walls(scene, k_half_width_m, 2);
  std::vector<Vec3> floor_m{{0, 0, 0.8 * k_side_m}};
  for (const double height : {0.0, -0.02}) {
    for (const double x : {-k_half_width_m, k_half_width_m}) {
      for (const double y : {-k_half_width_m, k_half_width_m})
        floor_m.emplace_back(x, y, height);
    }
  }
  scene.convexes.push_back(static_hull("floor", floor_m));
  for (int k = 0; k < 4; ++k)
    scene.convexes.push_back(funnel_slab(k_half_width_m, k));

  const auto drop = [](random::Stream& from) -> StartState {
    return {.pose = {.position_m = {between(from, -0.05, 0.05), between(from, -0.05, 0.05), 0.28},
                     .orientation = random::UniformRotation{}.draw(from)},
            .twist = {}};
  };
  for (std::uint32_t i = 0; i < bodies; ++i) {
    BodyDescription grain = body_of(grain_of(k_side_m, stream), {}, {});
    grain.start = drop(stream);
    grain.start_tick = Tick{} + ticks_after(0.05 * i);
    grain.start_again = [seed, i, drop](std::uint32_t attempt) {
      random::Stream again({.seed = seed, .chain = {i}, .purpose = random::Purpose::start},
                           attempt);
      return drop(again);
    };
    scene.bodies.push_back(std::move(grain));
  }
  return setting;
}

Setting cube_drop(std::uint32_t bodies, std::uint64_t seed) {
  constexpr double k_side_m = 0.02;
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{
      .scene = floor_scene(slow_contacts_of(k_side_m), {.restitution = 0.5, .friction = 0.4}),
      .duration_s = 3};
  const Solid solid = cube_of(k_side_m);
  for (std::uint32_t i = 0; i < bodies; ++i) {
    const Vec3 place_m(0.06 * i, 0, between(stream, 0.05, 0.1));
    BodyDescription body = body_of(
        solid, {}, {.position_m = place_m, .orientation = random::UniformRotation{}.draw(stream)});
    body.start.twist = {.velocity_mps = vector_between(stream, -0.1, 0.1),
                        .angular_velocity_radps = vector_between(stream, -10, 10)};
    setting.scene.bodies.push_back(std::move(body));
  }
  return setting;
}

Setting cube_stack(std::uint32_t bodies, std::uint64_t seed) {
  constexpr double k_side_m = 0.02;
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{
      .scene = floor_scene(slow_contacts_of_heaps(k_side_m), {.restitution = 0.3, .friction = 0.5}),
      .duration_s = 3};
  const Solid solid = cube_of(k_side_m);
  for (std::uint32_t i = 0; i < bodies; ++i) {
    const Vec3 place_m(between(stream, -0.001, 0.001), between(stream, -0.001, 0.001),
                       (i + 0.5) * k_side_m + (i + 1) * 0.0005);
    setting.scene.bodies.push_back(body_of(solid, {}, {.position_m = place_m}));
  }
  return setting;
}

Setting grain_heap(std::uint32_t bodies, std::uint64_t seed) {
  constexpr double k_side_m = 0.01;
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{
      .scene = floor_scene(slow_contacts_of_heaps(k_side_m), {.restitution = 0.3, .friction = 0.5}),
      .duration_s = 5};
  const double half_m = 0.06;
  add_walls(setting.scene, half_m, 2);
  // Place bodies on a loose lattice. A layer has five by five bodies.
  for (std::uint32_t i = 0; i < bodies; ++i) {
    const Vec3 place_m(0.022 * (i % 5) - 0.044, 0.022 * (i / 5 % 5) - 0.044,
                       0.015 + 0.022 * (i / 25));
    setting.scene.bodies.push_back(
        body_of(grain_of(k_side_m, stream), {},
                {.position_m = place_m, .orientation = random::UniformRotation{}.draw(stream)}));
  }
  return setting;
}

Setting wall(std::uint32_t bodies, std::uint64_t seed) {
  const Vec3 brick_m(0.2, 0.1, 0.1);
  constexpr double k_joint_m = 0.0005;  // between bricks of a row
  constexpr double k_ball_m = 0.15;
  constexpr double k_density_kgpm3 = 1500;
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{.scene = floor_scene(slow_contacts_of_heaps(brick_m.z()),
                                       {.restitution = 0.2, .friction = 0.5}),
                  .duration_s = 1};
  std::vector<BodyDescription>& all = setting.scene.bodies;
  const Vec3 half_m(0.5 * (brick_m.x() - k_joint_m), brick_m.y(), brick_m.z());
  const Solid brick = solid_of(box(brick_m).value(), k_density_kgpm3, InertiaSymmetry::general);
  const Solid half = solid_of(box(half_m).value(), k_density_kgpm3, InertiaSymmetry::general);
  const std::uint32_t bricks = std::max(bodies, 1U) - 1;
  const double pitch_m = brick_m.x() + k_joint_m;
  const auto add = [&](const Solid& solid, double x_m, std::uint32_t row) {
    if (all.size() == bricks) return;
    all.push_back(body_of(solid, {}, {.position_m = {x_m, 0, (row + 0.5) * brick_m.z()}}));
    all.back().rests = true;
  };
  // Every other row begins and ends with half a brick.
  const auto in_a_row =
      std::min(bricks, static_cast<std::uint32_t>(std::ceil(std::sqrt(2.0 * bricks))));
  const double end_m = 0.5 * (in_a_row - 1.0) * pitch_m;
  for (std::uint32_t row = 0; all.size() < bricks; ++row) {
    const bool shifted = row % 2 != 0;
    const double half_at_m = end_m + 0.5 * (brick_m.x() - half_m.x());
    if (shifted) add(half, -half_at_m, row);
    for (std::uint32_t i = 0; i + (shifted ? 1 : 0) < in_a_row; ++i)
      add(brick, (i + (shifted ? 0.5 : 0)) * pitch_m - end_m, row);
    if (shifted) add(half, half_at_m, row);
  }
  const double height_m = all.empty() ? 0 : all.back().start.pose.position_m.z();
  all.push_back(
      {.name = "ball",
       .shape = Sphere{.radius_m = k_ball_m},
       .inertia = solid_ball_inertia(30, k_ball_m),
       .start = {.pose = {.position_m = {between(stream, -0.1, 0.1), -0.3,
                                         std::max(0.5 * height_m, k_ball_m + 0.01)}},
                 .twist = {.velocity_mps = {0, 5, 1}, .angular_velocity_radps = Vec3::Zero()}}});
  return setting;
}

}  // namespace sleight::physics::scenes
