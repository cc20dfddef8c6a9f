// Random changes of scenes, like a sampler's proposals: one change or several, early or late.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/scenes/shared/scenes.h"
#include "tests/unit/worker/physics/scene/random_friction.h"
#include "tests/unit/worker/physics/simulator/dice.h"
#include "tests/unit/worker/physics/simulator/fixed_and_filtered.h"
#include "tests/unit/worker/physics/simulator/noised_scenes.h"
#include "worker/physics/scene/scene.h"

namespace sleight::physics::testing {

/// The scene that proposals change, and the sizes of the changes.
struct Subject {
  std::string name;
  Scene scene;
  double duration_s = 1;
  double size_m = 0.01;  ///< of a body
  double speed_mps = 0.3;
  bool fixes = false;     ///< proposals also fix bodies and change groups
  bool noised = false;    ///< proposals mostly change contact noise
  bool standing = false;  ///< of standing_slabs(): proposals keep the starts at rest
};

inline double reach_m(const BodyDescription& body) {
  if (const auto* sphere = std::get_if<Sphere>(&body.shape)) return sphere->radius_m;
  return std::get<std::shared_ptr<const Compound>>(body.shape)->r_outer_m();
}

/// Changes a body's start, velocities or start time, removes the body, or restores its first start.
inline void change_body(Scene& scene, const Subject& subject, Dice& dice) {
  const auto chosen = dice.below(scene.bodies.size());
  BodyDescription& body = scene.bodies[chosen];
  const BodyDescription& first = subject.scene.bodies[chosen];
  body.start = first.start;
  body.start_tick = first.start_tick;
  switch (dice.below(6)) {
    case 0:
      body.start_tick = k_tick_max;
      break;
    case 1:
      break;  // restores the first start, and the body if it was removed
    case 2:
      body.start.twist.velocity_mps += dice.vector_within(subject.speed_mps);
      break;
    case 3:
      body.start.twist.angular_velocity_radps += dice.vector_within(5);
      break;
    case 4:
      body.start_tick = body.start_tick + ticks_after(std::abs(dice.within(subject.duration_s)));
      break;
    default:
      body.start.pose.position_m += dice.vector_within(0.3 * subject.size_m);
  }
}

/// Moves a vertex of a mesh, a polyhedron or a plane, or changes a plane's friction.
inline void change_statics(Scene& scene, const Subject& subject, Dice& dice) {
  const double way_m = (dice.one_in(2) ? 0.05 : 0.4) * subject.size_m;
  const auto kind = dice.below(3);
  if (kind == 0 && !scene.meshes.empty()) {
    StaticMesh& placed = scene.meshes[dice.below(scene.meshes.size())];
    auto mesh = std::make_shared<TriangleMesh>(*placed.mesh);
    std::vector<VertexMove> moves;
    for (auto k = 1 + dice.below(3); k > 0; --k) {
      const auto vertex = static_cast<std::uint32_t>(dice.below(mesh->vertices_m().size()));
      moves.push_back({vertex, mesh->vertices_m()[vertex] + dice.vector_within(way_m)});
    }
    if (!mesh->move_vertices(moves)) placed.mesh = std::move(mesh);
  } else if (kind == 1 && !scene.convexes.empty()) {
    StaticConvex& convex = scene.convexes[dice.below(scene.convexes.size())];
    std::vector<Vec3> points_m(convex.polyhedron->vertices_m().begin(),
                               convex.polyhedron->vertices_m().end());
    const Vec3 shift_m = dice.vector_within(way_m);
    if (dice.one_in(2)) {
      for (Vec3& point_m : points_m)
        point_m += shift_m;
    } else {
      points_m[dice.below(points_m.size())] += shift_m;
    }
    auto hull = convex_hull(points_m);
    if (hull) convex.polyhedron = std::make_shared<const ConvexPolyhedron>(std::move(hull).value());
  } else if (!scene.planes.empty()) {
    // Mostly moves the plane away from the bodies. If the plane moved towards the bodies, it would
    // overlap some of them at the start.
    StaticPlane& plane = scene.planes[dice.below(scene.planes.size())];
    if (dice.one_in(2)) {
      random::Stream stream({.seed = dice.below(1000), .purpose = random::Purpose::prior}, 0);
      plane.friction_map = random_friction(stream, plane.outside, 12, 8 * subject.size_m);
      return;
    }
    plane.outside.offset_m += dice.within(way_m) - 0.5 * way_m;
  }
}

/// Kicks a body at a random time, or removes a kick.
inline void change_controls(Scene& scene, const Subject& subject, Dice& dice) {
  if (!scene.controls.empty() && dice.one_in(2)) {
    scene.controls.erase(scene.controls.begin() +
                         static_cast<std::ptrdiff_t>(dice.below(scene.controls.size())));
    return;
  }
  scene.controls.push_back({.tick = Tick{} + ticks_after(std::abs(dice.within(subject.duration_s))),
                            .body = {static_cast<std::uint32_t>(dice.below(scene.bodies.size()))},
                            .velocity_change_mps = dice.vector_within(subject.speed_mps),
                            .angular_velocity_change_radps = dice.vector_within(5)});
}

/// Fixes or releases a body, moves a fixed body, or changes a group or the filter.
inline void change_fixed(Scene& scene, const Subject& subject, Dice& dice) {
  const auto chosen = dice.below(scene.bodies.size());
  BodyDescription& body = scene.bodies[chosen];
  const auto kind = dice.below(12);
  if (kind < 4) {
    const BodyDescription& first = subject.scene.bodies[chosen];
    body.fixed = !body.fixed && scene.period_m == std::array<double, 3>{};
    body.start = first.start;
    body.inertia = first.inertia;
  } else if (kind < 8) {
    body.group = random_group(dice);
  } else if (kind < 10 && !scene.planes.empty() && may_regroup_statics(scene)) {
    scene.planes[dice.below(scene.planes.size())].group = random_group(dice);
  } else if (kind == 11) {
    scene.filter.set_meet({1}, {1}, !scene.filter.meet({1}, {1}));
  } else {
    for (BodyDescription& one : scene.bodies) {
      if (one.fixed && dice.one_in(2))
        one.start.pose.position_m += dice.vector_within(0.3 * subject.size_m);
    }
  }
}

inline void change(Scene& scene, const Subject& subject, Dice& dice) {
  if (subject.noised && dice.one_in(2)) {
    change_noise(scene, dice);
    return;
  }
  if (subject.standing) {
    change_slab(scene, dice);
    return;
  }
  if (subject.fixes && dice.one_in(3)) {
    change_fixed(scene, subject, dice);
    settle_fixed(scene);
    return;
  }
  const auto kind = dice.below(40);
  if (kind < 26) {
    change_body(scene, subject, dice);
  } else if (kind < 34) {
    change_statics(scene, subject, dice);
  } else if (kind < 37) {
    change_controls(scene, subject, dice);
  } else if (kind < 38) {
    for (BodyDescription& body : scene.bodies)
      body.start.twist.velocity_mps += dice.vector_within(0.1 * subject.speed_mps);
  } else if (kind < 39) {
    BodyDescription& body = scene.bodies[dice.below(scene.bodies.size())];
    body.inertia.mass_kg *= 1.5;
    body.inertia.principal_kgm2 *= 1.5;
  } else {
    scene.contacts.set({}, {}, {.restitution = 0.45, .friction = 0.35, .rolling_friction = 0.01});
  }
  settle_fixed(scene);
}

/// The n-th subject of an endless list: spheres in a box, an hourglass, heaps and walls that rest.
inline Subject subject_of(std::uint64_t n) {
  const std::uint64_t seed = n / 8 + 1;
  if (n % 9 == 8 && seed % 3 == 2) {
    // No body starts at rest, because most changes of such a start would be refused.
    const auto bodies = static_cast<std::uint32_t>(3 + seed / 3 % 9);
    Scene scene = scenes::wall(bodies, seed).scene;
    for (BodyDescription& body : scene.bodies) {
      body.rests = false;
      body.start.pose.position_m.z() *= 1.005;
    }
    return {"wall " + std::to_string(bodies), std::move(scene), 0.2, 0.001, 0.3};
  }
  if (n % 9 == 8) {
    const auto bodies = static_cast<std::uint32_t>(2 + seed % 7);
    return {"round_solids " + std::to_string(bodies), scenes::round_solids(bodies, seed).scene, 0.4,
            0.02, 0.3};
  }
  const auto from_to = [&](std::uint64_t low, std::uint64_t high) {
    return static_cast<std::uint32_t>(low + seed * 7 % (high - low + 1));
  };
  switch (n % 8) {
    case 0: {
      const auto bodies = from_to(3, 40);
      return {"boxed_spheres " + std::to_string(bodies), scenes::boxed_spheres(bodies, seed).scene,
              6, 1, 1};
    }
    case 1: {
      const auto bodies = from_to(2, 7);
      return {"hourglass " + std::to_string(bodies), scenes::hourglass(bodies, seed).scene, 0.6,
              0.01, 0.3};
    }
    case 2: {
      const auto bodies = from_to(3, 14);
      Scene scene = scenes::marbles(bodies, seed).scene;
      for (std::uint32_t i = 0; i < bodies; ++i)
        scene.bodies[i].start_tick = Tick{TickCount{100'000'000} * (i / 3)};
      return {"marbles " + std::to_string(bodies), std::move(scene), 1.5, 0.02, 0.3};
    }
    case 3: {
      const auto bodies = from_to(2, 6);
      return {"grain_heap " + std::to_string(bodies), scenes::grain_heap(bodies, seed).scene, 0.5,
              0.01, 0.3};
    }
    case 4: {
      const auto bodies = from_to(2, 8);
      return {"tray " + std::to_string(bodies), scenes::tray(bodies, seed).scene, 0.4, 0.01, 0.3};
    }
    case 5: {
      const auto bodies = from_to(1, 4);
      return {"cube_stack " + std::to_string(bodies), scenes::cube_stack(bodies, seed).scene, 0.4,
              0.02, 0.1};
    }
    case 6: {
      const auto bodies = from_to(4, 30);
      return {"rain " + std::to_string(bodies), scenes::rain(bodies, seed).scene, 1.5, 0.1, 1};
    }
    default: {
      // No body rests, and the space is periodic.
      const auto bodies = from_to(24, 60);
      return {"gas " + std::to_string(bodies), scenes::hard_sphere_gas(bodies, 0.1, seed).scene,
              0.5, 0.5, 1};
    }
  }
}

}  // namespace sleight::physics::testing
