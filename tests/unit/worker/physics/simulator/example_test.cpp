// Goal: the example of docs/SIMULATOR.md works. Method: run the lines of the example.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/scenes/shared/scenes.h"
#include "worker/physics/simulator/simulation.h"

namespace {

int bounce() {
  using namespace sleight::physics;

  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.contacts = ContactTable(1, {.restitution = 0.8, .friction = 0.3});
  scene.slow = scenes::slow_contacts_of(0.04);  // rest, for bodies of 4 cm
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  scene.bodies.push_back({.name = "ball",
                          .shape = Sphere{.radius_m = 0.02},
                          .inertia = solid_ball_inertia(0.1, 0.02),
                          .start = {.pose = {.position_m = {0, 0, 1}}, .twist = {}}});

  auto started = Simulation::start(scene, {});
  if (!started) return std::puts(started.error().message.c_str());  // names the body
  Simulation simulation = std::move(started).value();
  const auto error = simulation.run_until(Tick{} + ticks_after(10));
  if (error) return std::puts(error->message.c_str());

  for (const auto& [segment, cause] : simulation.recording().segments({0})) {
    std::printf("from %.6f s: %s at height %.4f m\n", seconds(segment.flight.begin - Tick{}),
                segment.mode == MotionMode::free ? "flies" : "rests or rolls",
                segment.flight.position_m.z());
  }
  return 0;
}

TEST(Example, ABallBouncesAndRests) {
  EXPECT_EQ(bounce(), 0);
}

}  // namespace
