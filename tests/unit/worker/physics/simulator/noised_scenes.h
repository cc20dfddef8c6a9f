// Contact noise for random scenes, its changes, and bodies that start at rest and topple.
//
// Thread safety: pure functions.
#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "common/random/distributions.h"
#include "tests/unit/worker/physics/simulator/dice.h"
#include "worker/physics/scene/scene.h"
#include "worker/physics/shape/mass_properties.h"

namespace sleight::physics::testing {

/// Values of a key, except at some addresses.
struct RandomNoise final : NoiseValues {
  std::uint64_t key = 0;
  std::map<NoiseAddress, NoiseValue> overrides;

  NoiseValue at(const NoiseAddress& address) const override {
    if (const auto found = overrides.find(address); found != overrides.end()) return found->second;
    random::Stream stream({.seed = key, .purpose = random::Purpose::prior},
                          (std::uint64_t{address.lower} << 40U) ^
                              (std::uint64_t{address.higher} << 8U) ^ address.number);
    return drawn(stream);
  }
  static NoiseValue drawn(random::Stream& stream) {
    const random::Normal normal{};
    const double first = normal.draw(stream);
    const double second = normal.draw(stream);
    return {first, second, normal.draw(stream)};
  }
};

inline void add_noise(Scene& scene, double above_mps, Dice& dice) {
  auto values = std::make_shared<RandomNoise>();
  values->key = dice.below(1000);
  scene.noise = {.above_mps = above_mps,
                 .tilt_sd_rad = 0.05,
                 .restitution_sd = dice.one_in(4) ? 0 : 0.05,
                 .values = std::move(values)};
}

/// Overrides the value of one impact, or changes the key.
inline void change_noise(Scene& scene, Dice& dice) {
  auto values = std::make_shared<RandomNoise>(static_cast<const RandomNoise&>(*scene.noise.values));
  if (dice.one_in(6)) {
    values->key = dice.below(1000);
  } else {
    const auto body = static_cast<std::uint32_t>(dice.below(scene.bodies.size()));
    const auto other = static_cast<std::uint32_t>(dice.below(2 * scene.bodies.size()));
    NoiseAddress address{body, other, static_cast<std::uint32_t>(1 + dice.below(5))};
    if (other >= scene.bodies.size()) address.higher = k_static | (other % 2);
    values->overrides[address] = RandomNoise::drawn(dice.stream);
  }
  scene.noise.values = std::move(values);
}

/// Slabs that stand on a floor, a brick on every third one, and a ball that comes at the first.
inline Scene standing_slabs(std::uint32_t slabs) {
  const auto description = [](const Vec3& sides_m, const Vec3& place_m) {
    const ConvexPolyhedron polyhedron = box(sides_m).value();
    const BodyShape shape = in_body_frame({&polyhedron, 1}, 700, InertiaSymmetry::general).value();
    return BodyDescription{
        .name = {},
        .shape = std::make_shared<const Compound>(Compound{shape.parts}),
        .inertia = shape.inertia,
        .start = {.pose = {shape.frame.position_m + place_m, shape.frame.orientation}, .twist = {}},
        .rests = true};
  };
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, {.restitution = 0.4, .friction = 0.4});
  scene.slow = coarse_slow_contacts_of(0.01, 9.81);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  scene.bodies.push_back(
      {.name = {},
       .shape = Sphere{.radius_m = 0.01},
       .inertia = solid_ball_inertia(0.03, 0.01),
       .start = {.pose = {.position_m = {-0.05, 0, 0.045}}, .twist = {.velocity_mps = {1, 0, 0}}}});
  for (std::uint32_t i = 0; i < slabs; ++i) {
    scene.bodies.push_back(description({0.01, 0.03, 0.05}, {0.04 * i, 0, 0.025}));
    if (i % 3 == 2) scene.bodies.push_back(description({0.01, 0.02, 0.01}, {0.04 * i, 0, 0.055}));
  }
  return scene;
}

/// Moves or turns a slab or a brick a little, so that it still starts at rest.
inline void change_slab(Scene& scene, Dice& dice) {
  Pose& pose = scene.bodies[1 + dice.below(scene.bodies.size() - 1)].start.pose;
  if (dice.one_in(2)) {
    pose.position_m.x() += dice.within(0.001);
  } else {
    const double half = dice.within(0.05);
    pose.orientation = math::normalized(
        math::composed(Quat(std::cos(half), 0, 0, std::sin(half)), pose.orientation));
  }
}

}  // namespace sleight::physics::testing
