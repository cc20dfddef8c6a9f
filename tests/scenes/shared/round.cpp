// Scenes of round bodies: solids of all kinds, and a bowling ball that hits ten pins.
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/math/elementary.h"
#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "worker/physics/shape/round_solids.h"

namespace sleight::physics::scenes {
namespace {

BodyDescription body_of(const RoundSolid& solid, const StartState& start) {
  return {
      .name = {},
      .shape = std::make_shared<const Compound>(Compound{.parts = {}, .round_parts = solid.parts}),
      .inertia = solid.inertia,
      .start = start};
}

/// Returns a solid of about one centimetre.
RoundSolid solid_of_kind(std::uint32_t kind) {
  constexpr double k_density_kgpm3 = 2500;
  switch (kind % 6) {
    case 0:
      return cylinder(0.008, 0.02, 0.0005, k_density_kgpm3).value();
    case 1:
      return coin(0.012, 0.003, k_density_kgpm3).value();
    case 2:
      return capsule(0.006, 0.015, k_density_kgpm3).value();
    case 3:
      return cone(0.01, 0.02, 0.0005, k_density_kgpm3).value();
    case 4:
      return rounded_box({0.02, 0.012, 0.008}, 0.001, k_density_kgpm3).value();
    default:
      return rounded_box({0.016, 0.016, 0.016}, 0.002, k_density_kgpm3).value();
  }
}

}  // namespace

Setting round_solids(std::uint32_t bodies, std::uint64_t seed) {
  constexpr double k_size_m = 0.02;
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{.scene = {}, .duration_s = 2};
  Scene& scene = setting.scene;
  scene.gravity_mps2 = {0, 0, -k_gravity_mps2};
  scene.contacts = ContactTable(1, {.restitution = 0.4, .friction = 0.3});
  scene.slow = slow_contacts_of(k_size_m);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  for (int side = 0; side < 4; ++side) {
    const double sign = side % 2 == 0 ? 0.8 : -0.8;
    const Vec3 inwards = side < 2 ? Vec3(sign, 0, 0.6) : Vec3(0, sign, 0.6);
    scene.planes.push_back({.name = "wall", .outside = {.normal = inwards, .offset_m = -0.06}});
  }
  scene.convexes.push_back(
      {.name = "block",
       .polyhedron = std::make_shared<const ConvexPolyhedron>(box({0.03, 0.04, 0.03}).value())});
  for (std::uint32_t i = 0; i < bodies; ++i) {
    const Vec3 site_m(0.04 * (i % 2) - 0.02, 0.04 * (i / 2 % 2) - 0.02, 0.05 + 0.04 * (i / 4));
    const StartState start{.pose = {.position_m = site_m + vector_between(stream, -0.002, 0.002),
                                    .orientation = random::UniformRotation{}.draw(stream)},
                           .twist = {.velocity_mps = vector_between(stream, -0.3, 0.3),
                                     .angular_velocity_radps = vector_between(stream, -20, 20)}};
    const auto kind = static_cast<std::uint32_t>((i + seed) % 8);
    if (kind < 6) {
      scene.bodies.push_back(body_of(solid_of_kind(kind), start));
    } else if (kind == 6) {
      scene.bodies.push_back({.name = {},
                              .shape = Sphere{.radius_m = 0.01},
                              .inertia = solid_ball_inertia(0.01, 0.01),
                              .start = start});
    } else {
      BodyShape cubic =
          in_body_frame(std::vector{cube(0.016).value()}, 2500, InertiaSymmetry::spherical).value();
      scene.bodies.push_back(
          {.name = {},
           .shape = std::make_shared<const Compound>(Compound{.parts = std::move(cubic.parts)}),
           .inertia = cubic.inertia,
           .start = start});
    }
  }
  return setting;
}

Setting bowling(std::uint32_t bodies, std::uint64_t seed) {
  // Sizes and masses follow the rules of bowling. Restitution and friction are typical values.
  constexpr double k_foot_m = 0.0254 * 12;
  constexpr double k_ball_m = 0.1085;
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{.scene = {}, .duration_s = 3};
  Scene& scene = setting.scene;
  scene.gravity_mps2 = {0, 0, -k_gravity_mps2};
  scene.contacts = ContactTable(1, {.restitution = 0.6, .friction = 0.2});
  scene.slow = slow_contacts_of(0.12);
  scene.planes.push_back({.name = "deck", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  const RoundSolid pin = bowling_pin(1.55).value();
  const auto shape =
      std::make_shared<const Compound>(Compound{.parts = {}, .round_parts = pin.parts});
  // The pins form a triangle of four rows. Neighbouring pins are one foot apart. The head pin is at
  // the origin, and x points down the lane.
  std::uint32_t number = 0;
  for (int row = 0; row < 4; ++row) {
    for (int place = 0; place <= row && number + 1 < bodies; ++place) {
      const double x_m = row * 0.5 * std::numbers::sqrt3 * k_foot_m;
      const double y_m = (place - 0.5 * row) * k_foot_m;
      scene.bodies.push_back(
          {.name = "pin " + std::to_string(++number),
           .shape = shape,
           .inertia = pin.inertia,
           .start = {.pose = {.position_m = {x_m, y_m, pin.foot_m}}, .twist = {}},
           .rests = true});
    }
  }
  const double gyration_m2 = 0.38 * k_ball_m * k_ball_m;
  constexpr double k_ball_kg = 6.8;
  const double speed_mps = between(stream, 6, 9);
  const double angle = between(stream, 0, 0.1);
  const double moment = k_ball_kg * gyration_m2;
  scene.bodies.push_back(
      {.name = "ball",
       .shape = Sphere{.radius_m = k_ball_m},
       .inertia = {.mass_kg = k_ball_kg,
                   .principal_kgm2 = {moment, moment, moment},
                   .symmetry = InertiaSymmetry::spherical},
       .start = {
           .pose = {.position_m = {-0.6, between(stream, -0.12, 0), k_ball_m + 1e-6}},
           .twist = {.velocity_mps = speed_mps * Vec3(math::cos(angle), math::sin(angle), 0),
                     .angular_velocity_radps =
                         speed_mps / k_ball_m * Vec3(-math::sin(angle), math::cos(angle), 0)}}});
  return setting;
}

}  // namespace sleight::physics::scenes
