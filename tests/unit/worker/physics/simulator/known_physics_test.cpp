#include <gtest/gtest.h>

#include "tests/scenes/shared/scenes.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"

namespace sleight::physics::known_physics_test {

using testing::RecordedRun;

constexpr double k_g_mps2 = 9.81;

BodyDescription ball(const Vec3& place_m, const Vec3& velocity_mps, double radius_m = 0.02,
                     double mass_kg = 0.1) {
  return {.name = {},
          .shape = Sphere{.radius_m = radius_m},
          .inertia = solid_ball_inertia(mass_kg, radius_m),
          .start = {.pose = {.position_m = place_m}, .twist = {.velocity_mps = velocity_mps}}};
}

Scene floor_scene(const SurfaceLaw& law) {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -k_g_mps2};
  scene.contacts = ContactTable(1, law);
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  return scene;
}

std::vector<Recording::Entry> bounces(const RecordedRun& run, std::uint32_t body) {
  std::vector<Recording::Entry> found;
  for (const Recording::Entry& entry : run.recording.segments({body})) {
    if (entry.cause.kind == EventKind::collision) found.push_back(entry);
  }
  return found;
}

TEST(KnownPhysics, ABallBouncesAtTheTimesOfTheGeometricSeries) {
  // Goal: the first 20 bounces of a ball with restitution 0.8 have the right times and heights.
  // Method: compare times and heights with the geometric series. A ball collides at a height of
  // k_touch_m above the floor. Each bounce is detected up to a tick late. This error delays each
  // later bounce by up to 2/e more ticks.
  constexpr double k_restitution = 0.8;
  constexpr double k_radius_m = 0.02;
  constexpr double k_height_m = 1;
  Scene scene = floor_scene({.restitution = k_restitution, .friction = 0.3});
  scene.bodies.push_back(ball({0, 0, k_radius_m + k_touch_m + k_height_m}, {0, 0, 0}, k_radius_m));
  const RecordedRun run = testing::recorded(scene, 4.015);
  ASSERT_EQ(run.error, "");
  const auto hits = bounces(run, 0);
  ASSERT_GE(hits.size(), 20U);

  const long double fall_s = std::sqrt(2.0L * k_height_m / k_g_mps2);
  long double time_s = fall_s;
  long double up_mps = k_restitution * fall_s * k_g_mps2;
  double worst_ticks = 0;
  double worst_height = 0;
  for (std::size_t n = 0; n < 20; ++n) {
    const auto ticks = static_cast<long double>(hits[n].cause.tick.value);
    const auto late = static_cast<double>(ticks - time_s * 0x1p30L);
    worst_ticks = std::max(worst_ticks, std::fabs(late));
    // The bounce's height above the place of touch, computed from the velocity after the bounce.
    const double v = hits[n].segment.flight.velocity_mps.z();
    const double height_m =
        v * v / (2 * k_g_mps2) + hits[n].segment.flight.position_m.z() - k_radius_m - k_touch_m;
    const auto known_m = static_cast<double>(up_mps * up_mps / (2 * k_g_mps2));
    worst_height = std::max(worst_height, std::fabs(height_m / known_m - 1));
    time_s += 2 * up_mps / k_g_mps2;
    up_mps *= k_restitution;
  }
  std::printf("bounces: %.1f ticks off at most, heights %.1e\n", worst_ticks, worst_height);
  EXPECT_LT(worst_ticks, 3 * 20);
  // The error of v^2 at the touch is 2 g times the depth. The depth is at most a tick's travel,
  // 4e-9 m.
  EXPECT_LT(worst_height, 1e-6);
}

TEST(KnownPhysics, NewtonsCradlePassesTheBlowOn) {
  // Goal: if one, two or three of five balls in a row strike the others, the same number of balls
  // leaves at the other end. The rest stand still. The struck balls almost touch each other.
  for (const std::size_t strikers : {1U, 2U, 3U}) {
    Scene scene;
    for (std::size_t i = 0; i < 5; ++i) {
      const double x = static_cast<double>(i) * (0.04 + 2 * k_touch_m) - (i < strikers ? 0.01 : 0);
      scene.bodies.push_back(ball({x, 0, 0}, {i < strikers ? 1.0 : 0.0, 0, 0}));
    }
    const RecordedRun run = testing::recorded(scene, 0.1);
    ASSERT_EQ(run.error, "");
    EXPECT_EQ(run.counts.collisions, strikers * (5 - strikers));
    for (std::uint32_t i = 0; i < 5; ++i) {
      const double v = run.recording.segments({i}).back().segment.flight.velocity_mps.x();
      EXPECT_NEAR(v, i >= 5 - strikers ? 1 : 0, 1e-15) << "ball " << i;
    }
  }
}

TEST(KnownPhysics, SimultaneousBlowsAreResolvedInTheOrderOfPairs) {
  // Goal: if two pairs collide at one tick, the pair with lower ids collides first. Later
  // collisions start from the result (event.h). Method: let two balls hit a middle ball from both
  // sides at the same tick. Pairs (0, 1), (1, 2) and (0, 1) must collide in this order, and both
  // outer balls must fly back.
  Scene scene;
  for (const double x : {-1.0, 0.0, 1.0})
    scene.bodies.push_back(ball({x, 0, 0}, {-x, 0, 0}));
  const RecordedRun run = testing::recorded(scene, 2);
  ASSERT_EQ(run.error, "");
  const auto middle = bounces(run, 1);
  ASSERT_EQ(middle.size(), 3U);
  const Tick tick = Tick{} + ticks_after(1 - 0.04 - k_touch_m);
  for (const auto& [entry, lower] :
       {std::pair{middle[0], 0U}, std::pair{middle[1], 1U}, std::pair{middle[2], 0U}}) {
    EXPECT_EQ(entry.cause.tick, tick);
    EXPECT_EQ(entry.cause.lower, lower);
    EXPECT_EQ(entry.cause.higher, lower + 1);
  }
  EXPECT_EQ(middle[0].segment.flight.velocity_mps, Vec3(1, 0, 0));
  EXPECT_EQ(middle[1].segment.flight.velocity_mps, Vec3(-1, 0, 0));
  EXPECT_EQ(middle[2].segment.flight.velocity_mps, Vec3(0, 0, 0));
  EXPECT_EQ(run.recording.segments({0}).back().segment.flight.velocity_mps, Vec3(-1, 0, 0));
  EXPECT_EQ(run.recording.segments({2}).back().segment.flight.velocity_mps, Vec3(1, 0, 0));
}

/// Compressibility p V / (N k T) of hard spheres: the mean over blocks of time, and the mean's
/// standard error. Computed from the momentum that collisions transfer.
struct Pressure {
  double mean = 0;
  double error = 0;
};

Pressure pressure_of(std::uint32_t bodies, double packing, double block_s, int blocks,
                     std::uint64_t seed) {
  const Scene scene = scenes::hard_sphere_gas(bodies, packing, seed).scene;
  // Skip the first blocks, in which the lattice melts.
  const int melting = blocks / 5 + 1;
  const RecordedRun run = testing::recorded(scene, block_s * (melting + blocks));
  EXPECT_EQ(run.error, "");
  double twice_energy_j = 0;
  for (const BodyDescription& body : scene.bodies)
    twice_energy_j += math::dot(body.start.twist.velocity_mps, body.start.twist.velocity_mps);
  // Total momentum is 0, so 3 N - 3 degrees of freedom share the energy.
  const double kt_j = twice_energy_j / (3.0 * bodies - 3);
  std::vector<double> momenta_ns(static_cast<std::size_t>(melting + blocks));
  for (std::uint32_t body = 0; body < bodies; ++body) {
    const auto entries = run.recording.segments({body});
    for (std::size_t i = 1; i < entries.size(); ++i) {
      if (entries[i].cause.lower != body) continue;  // count each collision once
      const double s = seconds(entries[i].cause.tick - Tick{});
      const auto block = std::min(static_cast<std::size_t>(s / block_s), momenta_ns.size() - 1);
      momenta_ns[block] += math::norm(entries[i].segment.flight.velocity_mps -
                                      entries[i - 1].segment.flight.velocity_mps);
    }
  }
  double sum = 0;
  double squares = 0;
  for (std::size_t i = static_cast<std::size_t>(melting); i < momenta_ns.size(); ++i) {
    // Diameter and mass are 1.
    const double z = 1 + momenta_ns[i] / (3 * bodies * kt_j * block_s);
    sum += z;
    squares += z * z;
  }
  const double mean = sum / blocks;
  return {mean, std::sqrt((squares / blocks - mean * mean) / (blocks - 1))};
}

TEST(KnownPhysics, HardSpheresHaveTheirPressure) {
  // Goal: a gas of hard spheres in equilibrium has the right pressure. Method: compare the virial
  // of collisions with Carnahan and Starling, "Equation of state for nonattracting rigid spheres",
  // Journal of Chemical Physics 51 (1969): Z = (1 + phi + phi^2 - phi^3)/(1 - phi)^3. The tolerance
  // is four standard errors of block means plus 3e-3 Z. The term 3e-3 Z covers two systematic
  // deviations. The formula deviates by up to 2e-3 at packing 0.4, according to simulations. A gas
  // of 500 spheres deviates from an infinite gas by about Z/N = 2e-3.
  for (const double phi : {0.1, 0.3, 0.4}) {
    const double known =
        (1 + phi + phi * phi - phi * phi * phi) / ((1 - phi) * (1 - phi) * (1 - phi));
    const double block_s = 4 / (known - 1);
    const Pressure found = pressure_of(500, phi, block_s, 20, 7);
    std::printf("packing %.1f: Z = %.4f +- %.4f, Carnahan-Starling %.4f\n", phi, found.mean,
                found.error, known);
    EXPECT_NEAR(found.mean, known, 4 * found.error + 3e-3 * known) << "packing " << phi;
    EXPECT_LT(found.error, 0.01 * known);
  }
}

}  // namespace sleight::physics::known_physics_test
