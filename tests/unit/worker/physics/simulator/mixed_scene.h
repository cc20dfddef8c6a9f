// A scene in which different kinds of bodies meet. The shared scenes contain no such mixture.
//
// Thread safety: pure functions.
#pragma once

#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/shapes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::testing {

struct MixedSolid {
  std::shared_ptr<const Compound> shape;
  Inertia inertia;
};

inline MixedSolid mixed_solid(std::vector<ConvexPolyhedron> parts, InertiaSymmetry symmetry) {
  BodyShape body = in_body_frame(parts, 2500, symmetry).value();
  return {std::make_shared<const Compound>(Compound{.parts = std::move(body.parts)}), body.inertia};
}

/// Spheres, cubes, boxes, prisms and L-shaped bodies fall onto a block between four leaning walls.
inline Scene mixed_scene(std::uint64_t seed) {
  random::Stream stream = scenes::stream_of_scene(seed, 0);
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, {.restitution = 0.6, .friction = 0.4});
  scene.slow = scenes::slow_contacts_of(0.02);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  for (int side = 0; side < 4; ++side) {
    const double sign = side % 2 == 0 ? 0.8 : -0.8;
    const Vec3 inwards = side < 2 ? Vec3(sign, 0, 0.6) : Vec3(0, sign, 0.6);
    scene.planes.push_back({.name = "wall", .outside = {.normal = inwards, .offset_m = -0.05}});
  }
  scene.convexes.push_back(
      {.name = "block",
       .polyhedron = std::make_shared<const ConvexPolyhedron>(box({0.03, 0.04, 0.05}).value())});

  const Mat3 upright = Mat3::Identity();
  const std::vector<MixedSolid> solids{
      mixed_solid({cube(0.016).value()}, InertiaSymmetry::spherical),
      mixed_solid({box({0.03, 0.012, 0.006}).value()}, InertiaSymmetry::general),
      mixed_solid({regular_prism(6, 0.009, 0.02).value()}, InertiaSymmetry::axial),
      mixed_solid({box({0.024, 0.008, 0.008}).value(),
                   moved(box({0.008, 0.008, 0.016}).value(), upright, {-0.008, 0, 0.012})},
                  InertiaSymmetry::general)};
  for (std::uint32_t i = 0; i < 16; ++i) {
    const Vec3 place_m(0.04 * (i % 2) - 0.02 + scenes::between(stream, -0.002, 0.002),
                       0.04 * (i / 2 % 2) - 0.02 + scenes::between(stream, -0.002, 0.002),
                       0.06 + 0.04 * (i / 4));
    BodyDescription body{.name = {},
                         .shape = Sphere{.radius_m = 0.01},
                         .inertia = solid_ball_inertia(0.01, 0.01),
                         .start = {.pose = {.position_m = place_m}, .twist = {}}};
    const auto kind = (i + seed) % 5;
    if (kind < solids.size()) {
      body.shape = solids[kind].shape;
      body.inertia = solids[kind].inertia;
      body.start.pose.orientation = random::UniformRotation{}.draw(stream);
    }
    body.start.twist = {.velocity_mps = scenes::vector_between(stream, -0.3, 0.3),
                        .angular_velocity_radps = scenes::vector_between(stream, -20, 20)};
    scene.bodies.push_back(std::move(body));
  }
  return scene;
}

}  // namespace sleight::physics::testing
