// Spheres that fall into a box.
#include "tests/scenes/shared/random_starts.h"
#include "tests/scenes/shared/scenes.h"
#include "worker/physics/simulator/simulation.h"

namespace sleight::physics::scenes {
namespace {

constexpr double k_funnel_half_width_m = 0.1;

StartState above_the_box(random::Stream& stream) {
  return {.pose = {.position_m = {between(stream, -0.7 * k_funnel_half_width_m,
                                          0.7 * k_funnel_half_width_m),
                                  between(stream, -0.7 * k_funnel_half_width_m,
                                          0.7 * k_funnel_half_width_m),
                                  between(stream, 0.1, 0.3)},
                   .orientation = random::UniformRotation{}.draw(stream)},
          .twist = {.velocity_mps = vector_between(stream, -0.5, 0.5),
                    .angular_velocity_radps = vector_between(stream, -20, 20)}};
}

}  // namespace

Setting rain(std::uint32_t bodies, std::uint64_t seed) {
  random::Stream stream = stream_of_scene(seed, 0);
  Setting setting{.scene = {}, .duration_s = 0.5};
  Scene& scene = setting.scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.slow = {.separation_speed_mps = 0.01};

  // There are three materials. Each pair of materials has its own law.
  scene.contacts = ContactTable(3);
  for (std::uint8_t a = 0; a < 3; ++a) {
    for (std::uint8_t b = a; b < 3; ++b) {
      scene.contacts.set({a}, {b},
                         {.restitution = between(stream, 0.3, 1),
                          .friction = stream.uniform() < 0.3 ? 0 : stream.uniform()});
    }
  }

  const double lean = between(stream, 0, 0.3);
  const double length = std::sqrt(1 + lean * lean);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  for (int side = 0; side < 4; ++side) {
    const double sign = side % 2 == 0 ? 1 : -1;
    const Vec3 outwards = side < 2 ? Vec3(sign, 0, 0) : Vec3(0, sign, 0);
    const Vec3 normal = (Vec3(0, 0, lean) - outwards) / length;
    scene.planes.push_back(
        {.name = "wall",
         .outside = {.normal = normal, .offset_m = -k_funnel_half_width_m / length},
         .material = {static_cast<std::uint8_t>(side % 3)}});
  }

  for (std::uint32_t i = 0; i < bodies; ++i) {
    const double radius_m = between(stream, 0.004, 0.02);
    const double mass_kg = between(stream, 0.01, 0.2);
    const double when_s = stream.uniform() < 0.5 ? 0 : between(stream, 0, 0.2);
    scene.bodies.push_back({.name = {},
                            .shape = Sphere{.radius_m = radius_m},
                            .inertia = solid_ball_inertia(mass_kg, radius_m),
                            .material = {static_cast<std::uint8_t>(i % 3)},
                            .start_tick = Tick{} + ticks_after(when_s),
                            .start = above_the_box(stream),
                            .start_again = [seed, i](std::uint32_t attempt) {
                              random::Stream again(
                                  {.seed = seed, .chain = {i}, .purpose = random::Purpose::start},
                                  attempt);
                              return above_the_box(again);
                            }});
  }
  // Push every third body once.
  for (std::uint32_t i = 0; i < bodies; i += 3) {
    scene.controls.push_back({.tick = Tick{} + ticks_after(between(stream, 0.1, 0.5)),
                              .body = {i},
                              .velocity_change_mps = vector_between(stream, -1, 1)});
  }
  return setting;
}

}  // namespace sleight::physics::scenes
