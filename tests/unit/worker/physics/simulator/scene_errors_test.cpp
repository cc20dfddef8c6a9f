#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/scenes/shared/random_starts.h"
#include "tests/support/facts.h"
#include "tests/support/numbers.h"
#include "tests/unit/worker/physics/simulator/noised_scenes.h"
#include "tests/unit/worker/physics/simulator/recorded_run.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/shape/mass_properties.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using Kind = SceneError::Kind;

/// Two balls above a floor. The second has no name.
Scene good_scene() {
  Scene scene;
  scene.gravity_mps2 = {0, 0, -9.81};
  scene.planes.push_back({.name = "floor", .outside = {.normal = {0, 0, 1}, .offset_m = 0}});
  for (int i = 0; i < 2; ++i) {
    scene.bodies.push_back(
        {.name = i == 0 ? "ball" : "",
         .shape = Sphere{.radius_m = 0.02},
         .inertia = solid_ball_inertia(0.1, 0.02),
         .start = {.pose = {.position_m = {0, 0.1 * i, 1}, .orientation = Quat::Identity()},
                   .twist = {}}});
  }
  return scene;
}

struct Wrong {
  Kind kind;
  const char* facts;
  void (*spoil)(Scene& scene);
};

TEST(SceneErrors, EachFaultIsNamed) {
  // Goal: an invalid scene gives a typed error that names the culprit, the problem and the valid
  // values. Method: make one change at a time to a valid scene.
  const Wrong faults[] = {
      {Kind::bad_mass, "body 'ball': |mass|0 kg|1e-12|1000000000000 kg",
       [](Scene& s) { s.bodies[0].inertia.mass_kg = 0; }},
      {Kind::bad_mass, "body 1: |mass|nan kg|1e-12|1000000000000 kg",
       [](Scene& s) { s.bodies[1].inertia.mass_kg = k_nan; }},
      {Kind::bad_mass, "body 'ball': |moments|1, 0, 1 kg m^2|above 0",
       [](Scene& s) {
         s.bodies[0].inertia.principal_kgm2 = {1, 0, 1};
       }},
      {Kind::bad_mass, "body 'ball': |symmetry|equal moments|1, 1, 2 kg m^2",
       [](Scene& s) {
         s.bodies[0].inertia.principal_kgm2 = {1, 1, 2};
       }},
      {Kind::bad_mass, "body 'ball': |symmetry|equal moments|1, 2, 2 kg m^2",
       [](Scene& s) {
         s.bodies[0].inertia.principal_kgm2 = {1, 2, 2};
         s.bodies[0].inertia.symmetry = InertiaSymmetry::axial;
       }},
      {Kind::bad_mass, "body 'ball': |moments|1, 2, 4 kg m^2|largest exceeds",
       [](Scene& s) {
         s.bodies[0].inertia.principal_kgm2 = {1, 2, 4};
         s.bodies[0].inertia.symmetry = InertiaSymmetry::general;
       }},
      {Kind::bad_mass, "body 'ball': |sphere|equal moments|2, 2, 3 kg m^2",
       [](Scene& s) {
         s.bodies[0].inertia.principal_kgm2 = {2, 2, 3};
         s.bodies[0].inertia.symmetry = InertiaSymmetry::axial;
       }},
      {Kind::bad_mass,
       "body 'ball': |moments|1, 1, 1 kg m^2|4.0000000000000006e-14 to 4e-05 kg m^2",
       [](Scene& s) {
         s.bodies[0].inertia.principal_kgm2 = {1, 1, 1};
       }},
      {Kind::bad_mass, "body 'ball': |symmetry 77",
       [](Scene& s) { s.bodies[0].inertia.symmetry = InertiaSymmetry{77}; }},
      {Kind::bad_number, "separation speed|nan|1000000 m/s",
       [](Scene& s) { s.slow.separation_speed_mps = k_nan; }},
      {Kind::bad_number, "contact noise|0 m/s|0.1 rad|0.5 rad",
       [](Scene& s) {
         s.noise = {.tilt_sd_rad = 0.1, .values = std::make_shared<testing::RandomNoise>()};
       }},
      {Kind::bad_number, "rest speed|-1|1000000 m/s", [](Scene& s) { s.slow.rest_speed_mps = -1; }},
      {Kind::bad_number, "rest time|is 0|1e-06 to 1000000 s",
       [](Scene& s) { s.slow = {.rest_speed_mps = 0.01}; }},
      {Kind::bad_shape, "body 'ball': |radius|0 m|1e-06 to 1000000 m",
       [](Scene& s) { s.bodies[0].shape = Sphere{.radius_m = 0}; }},
      {Kind::bad_shape, "body 1: |radius|nan m|1e-06 to 1000000 m",
       [](Scene& s) { s.bodies[1].shape = Sphere{.radius_m = k_nan}; }},
      {Kind::bad_shape, "body 'ball': |no parts",
       [](Scene& s) { s.bodies[0].shape = std::shared_ptr<const Compound>(); }},
      {Kind::bad_shape, "body 'ball': |no parts",
       [](Scene& s) { s.bodies[0].shape = std::make_shared<const Compound>(); }},
      {Kind::bad_shape, "body 'ball': |part 0|no vertices",
       [](Scene& s) {
         s.bodies[0].shape =
             std::make_shared<const Compound>(Compound{.parts = {ConvexPolyhedron()}});
       }},
      {Kind::bad_reference, "body 1: |material is 1|materials is 1",
       [](Scene& s) { s.bodies[1].material = {1}; }},
      {Kind::bad_number, "body 1: |tick|-1|0 to 4503599627370496",
       [](Scene& s) { s.bodies[1].start_tick = Tick{-1}; }},
      {Kind::bad_number, "body 'ball': |(0, nan, 1) m|at most 1000000 m",
       [](Scene& s) { s.bodies[0].start.pose.position_m.y() = k_nan; }},
      {Kind::bad_number, "body 1: | velocity|(nan, 0, 0) m/s|at most 1000000 m/s",
       [](Scene& s) { s.bodies[1].start.twist.velocity_mps.x() = k_nan; }},
      {Kind::bad_number, "body 1: |angular velocity|(0, 0, 1e+100) rad/s|at most 1000000 rad/s",
       [](Scene& s) { s.bodies[1].start.twist.angular_velocity_radps.z() = 1e100; }},
      {Kind::bad_number, "body 1: |orientation|norm 0,|unit quaternion",
       [](Scene& s) { s.bodies[1].start.pose.orientation = Quat(0, 0, 0, 0); }},
      {Kind::bad_number, "body 1: |orientation|norm nan,|unit quaternion",
       [](Scene& s) { s.bodies[1].start.pose.orientation = Quat(1, k_nan, 0, 0); }},
      {Kind::bad_number, "gravity|(0, nan, 0) m/s^2|at most 10000 m/s^2",
       [](Scene& s) {
         s.gravity_mps2 = {0, k_nan, 0};
       }},
      {Kind::bad_number, "materials 0 and 0: |restitution|1.1|0 to 1",
       [](Scene& s) { s.contacts = ContactTable(1, {.restitution = 1.1}); }},
      {Kind::bad_number, "materials 0 and 1: |friction|-0.1|0 to 1e6",
       [](Scene& s) {
         s.contacts = ContactTable(2);
         s.contacts.set({0}, {1}, {.friction = -0.1});
       }},
      {Kind::bad_number, "materials 0 and 0: |rolling friction|nan|0 to 1",
       [](Scene& s) { s.contacts = ContactTable(1, {.rolling_friction = k_nan}); }},
      {Kind::bad_shape, "plane 'floor': |normal|length 1|offset|at most 1000000 m",
       [](Scene& s) {
         s.planes[0].outside.normal = {0, 0, 2};
       }},
      {Kind::bad_shape, "plane 'floor': |normal|length 1|offset|at most 1000000 m",
       [](Scene& s) { s.planes[0].outside.offset_m = k_nan; }},
      {Kind::bad_reference, "plane 'floor': |material is 3|materials is 1",
       [](Scene& s) { s.planes[0].material = {3}; }},
      {Kind::bad_shape, "convex 'block': |no vertices",
       [](Scene& s) { s.convexes.push_back({.name = "block", .polyhedron = nullptr}); }},
      {Kind::bad_reference, "convex 'block': |material is 1|materials is 1",
       [](Scene& s) {
         s.convexes.push_back(
             {.name = "block",
              .polyhedron = std::make_shared<const ConvexPolyhedron>(cube(0.1).value()),
              .material = {1}});
       }},
      {Kind::bad_number, "body 1: |can't be fixed|tick must be 0",
       [](Scene& s) {
         s.bodies[1].fixed = true;
         s.bodies[1].start_tick = Tick{1};
       }},
      {Kind::bad_number, "body 1: |can't be fixed|at rest",
       [](Scene& s) { s.bodies[1].fixed = s.bodies[1].rests = true; }},
      {Kind::bad_number, "body 1: |can't be fixed|start_again",
       [](Scene& s) {
         s.bodies[1].fixed = true;
         s.bodies[1].start_again = [](std::uint32_t) { return StartState{}; };
       }},
      {Kind::bad_reference, "control|body 1|fixed",
       [](Scene& s) {
         s.bodies[1].fixed = true;
         s.controls.push_back({.tick = Tick{5}, .body = {1}});
       }},
      {Kind::bad_number, "neither|static geometry|nor fixed bodies",
       [](Scene& s) {
         s.planes.clear();
         s.gravity_mps2 = Vec3::Zero();
         s.bodies[1].fixed = true;
         s.period_m = {1, 1, 1};
       }},
      {Kind::bad_reference, "body 1: |group is 32|0 to 31",
       [](Scene& s) { s.bodies[1].group = {32}; }},
      {Kind::bad_reference, "plane 'floor': |group is 255|0 to 31",
       [](Scene& s) { s.planes[0].group = {255}; }},
      {Kind::bad_reference, "control|body 2|bodies is 2",
       [](Scene& s) { s.controls.push_back({.tick = Tick{5}, .body = {2}}); }},
      {Kind::bad_number, "control of body 1|tick 5",
       [](Scene& s) {
         s.controls.push_back({.tick = Tick{5}, .body = {1}, .velocity_change_mps = {0, k_nan, 0}});
       }},
      {Kind::bad_number, "control of body 1|tick -5",
       [](Scene& s) { s.controls.push_back({.tick = Tick{-5}, .body = {1}}); }},
      {Kind::bad_number, "neither gravity nor static geometry",
       [](Scene& s) {
         s.period_m = {1, 1, 1};
       }},
      {Kind::bad_number, "period|above 0|or 0|-1 m",
       [](Scene& s) {
         s.period_m = {-1, 0, 0};
       }},
      {Kind::overlap, "body 1 can't start|at 0 s|overlaps body 'ball'|1e-07 m",
       [](Scene& s) { s.bodies[1].start.pose.position_m.y() = 0.03; }},
      {Kind::overlap, "body 'ball' can't start|at 0 s|overlaps plane 'floor'|1e-07 m",
       [](Scene& s) { s.bodies[0].start.pose.position_m.z() = 0.01; }},
      {Kind::overlap, "body 'ball' can't start|at 0 s|overlaps plane 'floor'|1e-07 m",
       [](Scene& s) { s.bodies[0].start.pose.position_m.z() = -1; }},
  };
  EXPECT_FALSE(error_of(good_scene()));
  EXPECT_TRUE(Simulation::start(good_scene(), {}).ok());
  for (const Wrong& wrong : faults) {
    Scene scene = good_scene();
    wrong.spoil(scene);
    const auto started = Simulation::start(scene, {});
    ASSERT_FALSE(started.ok()) << wrong.facts;
    EXPECT_THAT(started.error().message, tests::HasFacts(wrong.facts));
    EXPECT_EQ(started.error().kind, wrong.kind) << wrong.facts;
  }
}

TEST(SceneErrors, StartsThatTouchAreRefused) {
  // Goal: a start counts as an overlap if the gap to another body is at most k_touch_m. Method:
  // test slightly smaller and larger gaps.
  const auto compound = std::make_shared<const Compound>(Compound{.parts = {cube(0.04).value()}});
  for (const bool cubes : {false, true}) {
    for (const double gap_m : {-1e-3, 0.0, 0.9e-7, 1.1e-7}) {
      Scene scene = good_scene();
      scene.bodies[1].start.pose.position_m.y() = 0.04 + gap_m;
      if (cubes) {
        for (BodyDescription& body : scene.bodies)
          body.shape = compound;
      }
      EXPECT_EQ(Simulation::start(scene, {}).ok(), gap_m > k_touch_m) << cubes << ' ' << gap_m;
    }
  }
}

TEST(SceneErrors, ABodyInsideAStaticOneIsRefused) {
  // Goal: a start inside a static block is an error, even if the surfaces don't touch.
  for (const bool sphere : {true, false}) {
    Scene scene = good_scene();
    scene.convexes.push_back({.name = "block",
                              .polyhedron = std::make_shared<const ConvexPolyhedron>(
                                  moved(cube(0.5).value(), Mat3::Identity(), {0, 0, 1}))});
    scene.bodies.resize(1);
    if (!sphere) {
      scene.bodies[0].shape =
          std::make_shared<const Compound>(Compound{.parts = {cube(0.02).value()}});
    }
    const auto started = Simulation::start(scene, {});
    ASSERT_FALSE(started.ok()) << (sphere ? "ball" : "cube");
    EXPECT_THAT(started.error().message,
                tests::HasFacts("body 'ball' can't start|at 0 s|overlaps convex 'block'|1e-07 m"));
  }
}

/// The second ball starts in the place of the first ball, which rests there or flies past.
Scene late_start(bool moving, Tick tick) {
  Scene scene = good_scene();
  scene.slow = {.separation_speed_mps = 0.002, .rest_speed_mps = 0.013, .rest_time_s = 0.004};
  scene.contacts = ContactTable(1, {.restitution = 0.3, .friction = 0.5});
  scene.bodies[0].start.pose.position_m = {0, 0, 0.025};
  if (moving) {
    scene.gravity_mps2 = Vec3::Zero();
    scene.bodies[0].start.twist.velocity_mps = {1, 0, 0};
  }
  scene.bodies[1].start_tick = tick;
  scene.bodies[1].start.pose.position_m =
      moving ? Vec3(seconds(tick - Tick{}), 0.01, 0.03) : Vec3(0, 0.01, 0.03);
  return scene;
}

TEST(SceneErrors, ALaterStartOnABodyIsAnError) {
  // Goal: a late start is checked against the places of other bodies at that time. Method: start a
  // ball late on a resting ball, and on a moving ball. A start in a place that the moving ball has
  // left is valid.
  const Tick tick = Tick{} + ticks_after(0.5);
  for (const bool moving : {false, true}) {
    auto started = Simulation::start(late_start(moving, tick), {});
    ASSERT_TRUE(started.ok());
    Simulation simulation = std::move(started).value();
    EXPECT_FALSE(simulation.run_until(tick - 1));
    EXPECT_FALSE(simulation.started({1}));
    if (!moving) {
      EXPECT_EQ(simulation.kinetic_energy_j(), 0);
    }
    const auto error = simulation.run_until(tick + 1000);
    ASSERT_TRUE(error) << moving;
    EXPECT_EQ(error->kind, Kind::overlap);
    EXPECT_THAT(error->message,
                tests::HasFacts("body 1 can't start|at 0.5 s|overlaps body 'ball'|1e-07 m"));
    EXPECT_FALSE(simulation.started({1}));
    EXPECT_EQ(simulation.now(), tick);
    // The simulation stays at the tick at which it failed.
    const auto again = simulation.run_until(tick + 2000);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->message, error->message);
    EXPECT_EQ(simulation.now(), tick);
  }
  Scene gone = late_start(true, tick);
  gone.bodies[1].start.pose.position_m.x() = 0;
  EXPECT_EQ(testing::recorded(gone, 0.6).error, "");
}

TEST(SceneErrors, StartsAreDrawnAgain) {
  // Goal: an overlapping start is drawn again until it overlaps nothing. A draw depends only on the
  // attempt's number. Method: let all attempts before a given attempt overlap another body.
  for (const std::uint32_t free : {1U, 2U, 17U, 1000U}) {
    Scene scene = good_scene();
    std::vector<std::uint32_t> asked;
    scene.bodies[1].start = scene.bodies[0].start;
    scene.bodies[1].start_again = [&](std::uint32_t attempt) {
      asked.push_back(attempt);
      StartState start = scene.bodies[0].start;
      if (attempt >= free) start.pose.position_m.x() = 0.5;
      return start;
    };
    auto started = Simulation::start(scene, {});
    ASSERT_TRUE(started.ok()) << free;
    const Simulation simulation = std::move(started).value();
    EXPECT_EQ(simulation.counts().start_draws, free);
    EXPECT_EQ(simulation.counts().starts, 2U);
    EXPECT_EQ(simulation.pose({1}, Tick{}).position_m, Vec3(0.5, 0, 1));
    ASSERT_EQ(asked.size(), free);
    for (std::uint32_t i = 0; i < free; ++i)
      EXPECT_EQ(asked[i], i + 1);
    // Refused places leave no trace.
    ASSERT_EQ(simulation.recording().segments({1}).size(), 1U);
    EXPECT_EQ(simulation.recording().segments({1})[0].cause.kind, EventKind::start);
  }
}

TEST(SceneErrors, AThousandDrawsAreEnough) {
  // Goal: if 1000 attempts to draw a start overlap a body, the simulation gives an error. Method:
  // test a start at tick 0 and a late start. Make every attempt overlap.
  for (const double when_s : {0.0, 0.01}) {
    Scene scene = good_scene();
    scene.gravity_mps2 = Vec3::Zero();
    std::uint32_t asked = 0;
    scene.bodies[1].start = scene.bodies[0].start;
    scene.bodies[1].start_tick = Tick{} + ticks_after(when_s);
    scene.bodies[1].start_again = [&](std::uint32_t) {
      ++asked;
      return scene.bodies[0].start;
    };
    const std::string error = testing::recorded(scene, 0.1).error;
    EXPECT_THAT(error,
                tests::HasFacts(fmt::format("body 1 |at {} s|1000 attempts|overlaps body 'ball'",
                                            when_s == 0 ? "0" : "0.0100000007")));
    EXPECT_EQ(asked, k_start_attempts_max);
  }
}

TEST(SceneErrors, DrawnStartsAreCheckedToo) {
  // Goal: results of start_again are checked like user input. Method: return NaN at the first
  // attempt. A simulator without the check would stop the process.
  Scene scene = good_scene();
  scene.bodies[1].start = scene.bodies[0].start;
  scene.bodies[1].start_again = [&](std::uint32_t) {
    StartState start = scene.bodies[0].start;
    start.pose.position_m.x() = k_nan;
    return start;
  };
  const auto started = Simulation::start(scene, {});
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().kind, Kind::bad_number) << started.error().message;
}

}  // namespace
}  // namespace sleight::physics
