// Scenes in which bodies get where they can't leave by themselves, and what says so.
//
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "worker/physics/scenes/random_starts.h"
#include "worker/physics/scenes/scenes.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::testing {

/// More than rounding adds to heights and places.
inline constexpr double k_confined_margin_m = 1e-5;

/// How high a solid ball's centre may get by itself, from a state of its motion. Up is z.
inline double reach_of(const Scene& scene, BodyId body, const Segment& segment) {
  const double radius_m = std::get<Sphere>(scene.bodies[body.value].shape).radius_m;
  const Vec3& v = segment.flight.velocity_mps;
  const Vec3 w = radius_m * segment.flight.angular_velocity_radps;
  const double energy = math::dot(v, v) + 0.4 * math::dot(w, w);
  return segment.flight.position_m.z() + energy / (-2 * scene.gravity_mps2.z()) +
         k_confined_margin_m;
}

inline Box box_about(const Vec3& low_m, const Vec3& high_m, double margin_m) {
  Box box;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    box.low_m[axis] = static_cast<float>(low_m[i] - margin_m);
    box.high_m[axis] = static_cast<float>(high_m[i] + margin_m);
  }
  return box;
}

// ---- between planes -----------------------------------------------------------------------------

/// What lies above all of a scene's planes and below the height that the ball reaches: whatever
/// else is there, the ball stays there. REQUIRES: that is bounded.
inline std::optional<Box> between_planes(const Scene& scene, BodyId body, const Segment& segment) {
  const double radius_m = std::get<Sphere>(scene.bodies[body.value].shape).radius_m;
  std::vector<HalfSpace> sides{{.normal = {0, 0, -1}, .offset_m = -reach_of(scene, body, segment)}};
  for (const StaticPlane& plane : scene.planes) {
    sides.push_back({.normal = plane.outside.normal,
                     .offset_m = plane.outside.offset_m + radius_m - k_confined_margin_m});
  }
  // Its corners: where three planes meet.
  Vec3 low_m(1, 1, 1);
  Vec3 high_m(-1, -1, -1);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t j = i + 1; j < sides.size(); ++j) {
      for (std::size_t k = j + 1; k < sides.size(); ++k) {
        const Vec3 across = math::cross(sides[j].normal, sides[k].normal);
        const double volume = math::dot(sides[i].normal, across);
        if (std::fabs(volume) < 1e-9) continue;
        const Vec3 corner_m = (sides[i].offset_m * across +
                               sides[j].offset_m * math::cross(sides[k].normal, sides[i].normal) +
                               sides[k].offset_m * math::cross(sides[i].normal, sides[j].normal)) /
                              volume;
        const bool inside = std::ranges::all_of(sides, [&](const HalfSpace& side) {
          return math::dot(side.normal, corner_m) >= side.offset_m - 1e-9;
        });
        if (!inside) continue;
        for (int axis = 0; axis < 3; ++axis) {
          low_m[axis] = std::min(low_m[axis], corner_m[axis]);
          high_m[axis] = std::max(high_m[axis], corner_m[axis]);
        }
      }
    }
  }
  if (low_m.x() > high_m.x()) return std::nullopt;
  return box_about(low_m, high_m, radius_m + k_confined_margin_m);
}

// ---- cups ---------------------------------------------------------------------------------------

inline constexpr double k_cup_half_m = 0.022;  ///< inside
inline constexpr double k_cup_wall_m = 0.005;
inline constexpr double k_cup_height_m = 0.03;
inline constexpr double k_cup_bottom_m = 0.004;
inline constexpr std::array<std::array<double, 2>, 4> k_cups_m{
    {{-0.05, -0.05}, {0.05, -0.05}, {0.05, 0.05}, {-0.05, 0.05}}};

inline std::shared_ptr<const ConvexPolyhedron> block_of(const Vec3& low_m, const Vec3& high_m) {
  std::vector<Vec3> corners_m;
  for (int i = 0; i < 8; ++i) {
    corners_m.emplace_back((i & 1) != 0 ? high_m.x() : low_m.x(),
                           (i & 2) != 0 ? high_m.y() : low_m.y(),
                           (i & 4) != 0 ? high_m.z() : low_m.z());
  }
  return std::make_shared<const ConvexPolyhedron>(convex_hull(corners_m).value());
}

/// A closed mesh.
inline std::shared_ptr<const TriangleMesh> cup_mesh(double at_x_m, double at_y_m) {
  const double outside_m = k_cup_half_m + k_cup_wall_m;
  const std::array<double, 4> halves_m{outside_m, outside_m, k_cup_half_m, k_cup_half_m};
  const std::array<double, 4> heights_m{0, k_cup_height_m, k_cup_height_m, k_cup_bottom_m};
  std::vector<Vec3> vertices_m;
  for (std::size_t ring = 0; ring < 4; ++ring) {
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
      vertices_m.emplace_back(at_x_m + x * halves_m[ring], at_y_m + y * halves_m[ring],
                              heights_m[ring]);
  }
  std::vector<TriangleCorners> triangles{{3, 2, 1}, {3, 1, 0}, {12, 13, 14}, {12, 14, 15}};
  for (std::uint32_t ring = 0; ring < 12; ring += 4) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t next = (k + 1) % 4;
      triangles.push_back({ring + k, ring + next, ring + 4 + next});
      triangles.push_back({ring + k, ring + 4 + next, ring + 4 + k});
    }
  }
  return std::make_shared<const TriangleMesh>(
      TriangleMesh::make(vertices_m, triangles, MeshClosure::closed).value());
}

/// A floor between four walls with two cups that are meshes and two of blocks, and no ball.
inline Scene empty_cups() {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.slow = slow_contacts_of(0.01, 9.81);
  scene.contacts = ContactTable(1, {.restitution = 0.6, .friction = 0.2});
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 normal = Vec3::Zero();
      normal[axis] = -side;
      scene.planes.push_back({.name = "wall", .outside = {.normal = normal, .offset_m = -0.12}});
    }
  }
  for (std::size_t cup = 0; cup < k_cups_m.size(); ++cup) {
    const auto [x, y] = k_cups_m[cup];
    if (cup % 2 == 0) {
      scene.meshes.push_back({.name = "cup", .mesh = cup_mesh(x, y)});
      continue;
    }
    const double in = k_cup_half_m;
    const double out = in + k_cup_wall_m;
    const auto add = [&](double low_x, double high_x, double low_y, double high_y) {
      scene.convexes.push_back(
          {.name = "cup",
           .polyhedron = block_of({x + low_x, y + low_y, -0.01}, {x + high_x, y + high_y, 0.03})});
    };
    add(-out, -in, -out, out);
    add(in, out, -out, out);
    add(-in, in, -out, -in);
    add(-in, in, in, out);
  }
  return scene;
}

inline BodyDescription cup_ball(double radius_m, const Vec3& place_m) {
  BodyDescription ball;
  ball.shape = Sphere{.radius_m = radius_m};
  ball.inertia = solid_ball_inertia(1e4 * radius_m * radius_m * radius_m, radius_m);
  ball.start.pose.position_m = place_m;
  return ball;
}

/// The inside of a cup, for a ball in there that doesn't reach its rim.
inline std::optional<Box> in_a_cup(const Scene& scene, BodyId body, const Segment& segment) {
  const double radius_m = std::get<Sphere>(scene.bodies[body.value].shape).radius_m;
  const double reach_m = reach_of(scene, body, segment);
  const Vec3& centre_m = segment.flight.position_m;
  if (reach_m > k_cup_height_m) return std::nullopt;
  for (const auto& [x, y] : k_cups_m) {
    if (std::max(std::fabs(centre_m.x() - x), std::fabs(centre_m.y() - y)) > k_cup_half_m) continue;
    return box_about({x - k_cup_half_m, y - k_cup_half_m, 0},
                     {x + k_cup_half_m, y + k_cup_half_m, reach_m + radius_m}, k_confined_margin_m);
  }
  return std::nullopt;
}

/// Balls that begin in cups, others that are thrown at them later, and some that get a push. Every
/// third scene is elastic and has no slow contacts.
inline Scene cups(std::uint64_t seed) {
  random::Stream stream = scenes::stream_of_scene(seed, 3);
  const auto between = [&](double low, double high) { return scenes::between(stream, low, high); };
  Scene scene = empty_cups();
  if (seed % 3 == 0) {
    scene.slow = {};
    scene.contacts = ContactTable(1, {.restitution = 1, .friction = 0.2 * stream.uniform()});
  } else {
    scene.contacts =
        ContactTable(1, {.restitution = between(0, 0.8),
                         .friction = stream.uniform() < 0.2 ? 0 : between(0.05, 0.6),
                         .rolling_friction = stream.uniform() < 0.5 ? 0 : between(0, 0.03)});
  }
  for (const auto& [x, y] : k_cups_m) {
    const double radius_m = between(0.004, 0.009);
    const double room_m = k_cup_half_m - radius_m - 1e-4;
    BodyDescription ball =
        cup_ball(radius_m, {x + between(-room_m, room_m), y + between(-room_m, room_m),
                            k_cup_bottom_m + radius_m + between(0.0001, 0.006)});
    ball.start.twist = {.velocity_mps = scenes::vector_between(stream, -0.25, 0.25),
                        .angular_velocity_radps = scenes::vector_between(stream, -20, 20)};
    scene.bodies.push_back(std::move(ball));
  }
  for (int i = 0; i < 5; ++i) {
    const auto thrown = [seed, i](std::uint32_t attempt) {
      random::Stream again =
          scenes::stream_of_scene(seed, 100 + 100 * static_cast<std::uint64_t>(i) + attempt);
      const auto& cup_m = k_cups_m[again.bits() % k_cups_m.size()];
      StartState start;
      start.pose.position_m = Vec3(cup_m[0], cup_m[1], scenes::between(again, 0.045, 0.1)) +
                              scenes::vector_between(again, -0.02, 0.02);
      start.pose.position_m.z() += 0.02;
      // Half of them fall straight: going back from there, too, they would meet what is in the cup.
      const double aside_mps = again.bits() % 2 == 0 ? 0.3 : 0.03;
      start.twist = {.velocity_mps = scenes::vector_between(again, -aside_mps, aside_mps),
                     .angular_velocity_radps = scenes::vector_between(again, -40, 40)};
      return start;
    };
    BodyDescription ball = cup_ball(between(0.004, 0.009), Vec3::Zero());
    ball.start = thrown(0);
    ball.start_again = thrown;
    ball.start_tick = Tick{} + ticks_after(between(0, 1.2));
    scene.bodies.push_back(std::move(ball));
  }
  for (int i = 0; i < 4; ++i) {
    scene.controls.push_back(
        {.tick = Tick{} + ticks_after(between(0.1, 1.8)),
         .body = {static_cast<std::uint32_t>(stream.bits() % scene.bodies.size())},
         .velocity_change_mps = scenes::vector_between(stream, -0.6, 0.6)});
  }
  return scene;
}

}  // namespace sleight::physics::testing
