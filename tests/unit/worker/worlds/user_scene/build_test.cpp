// Goal: bodies have the mass, moments, centre and place that their shapes say, and run in the
// simulator. Method: compare forms with closed formulas and with each other, and let a marble run
// down a helix.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/worker/worlds/user_scene/read_scene.h"
#include "worker/physics/simulator/simulation.h"
#include "worker/worlds/user_scene/body_form.h"

namespace sleight::worlds::user_scene {
namespace {

BodyForm form_of(const ShapeSizes& sizes, std::span<const PartDescription> parts = {}) {
  auto form = body_form(sizes, parts, 1000);
  EXPECT_TRUE(form.ok());
  return std::move(form).value();
}

std::array<double, 3> sorted(const Vec3& moments) {
  std::array<double, 3> all{moments.x(), moments.y(), moments.z()};
  std::ranges::sort(all);
  return all;
}

void expect_same_moments(const BodyForm& a, const BodyForm& b, double tolerance) {
  EXPECT_NEAR(a.inertia.mass_kg, b.inertia.mass_kg, tolerance * b.inertia.mass_kg);
  const auto first = sorted(a.inertia.principal_kgm2);
  const auto second = sorted(b.inertia.principal_kgm2);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(first[i], second[i], tolerance * second[2]);
}

const Vec3 k_sides_m{0.02, 0.03, 0.05};

TEST(BodyForm, ABoxHasItsMomentsInAnyDisguise) {
  const BodyForm box = form_of({.kind = ShapeKind::box, .size_m = k_sides_m});
  const double mass_kg = 1000 * k_sides_m.prod();
  EXPECT_NEAR(box.inertia.mass_kg, mass_kg, 1e-15);
  EXPECT_NEAR(sorted(box.inertia.principal_kgm2)[2], mass_kg / 12 * (0.03 * 0.03 + 0.05 * 0.05),
              1e-18);

  // A hull of the corners, away from the origin.
  ShapeSizes hull{.kind = ShapeKind::hull};
  for (int i = 0; i < 8; ++i)
    hull.points_m.emplace_back(0.1 + (i & 1) * 0.02, (i >> 1 & 1) * 0.03, (i >> 2) * 0.05);
  const BodyForm of_hull = form_of(hull);
  expect_same_moments(of_hull, box, 1e-12);
  EXPECT_TRUE(of_hull.frame.position_m.isApprox(Vec3(0.11, 0.015, 0.025)));

  // Two halves, turned.
  const Quat turn = math::quaternion_of_rotation_vector({0.3, -0.4, 0.5});
  std::vector<PartDescription> halves;
  for (const double z_m : {-0.0125, 0.0125})
    halves.push_back(
        {.sizes = {.kind = ShapeKind::box, .size_m = {0.02, 0.03, 0.025}},
         .pose = {.position_m = math::rotated(turn, Vec3(0, 0, z_m)), .orientation = turn}});
  const BodyForm of_halves = form_of({.kind = ShapeKind::compound}, halves);
  expect_same_moments(of_halves, box, 1e-12);
  EXPECT_LT(of_halves.frame.position_m.norm(), 1e-12);
  EXPECT_EQ(of_halves.polyhedra.size(), 2U);
}

TEST(BodyForm, RoundShapesHaveTheirMomentsAndOrigins) {
  // With small edges, a cylinder's volume is that of the sharp one, up to the edges.
  const BodyForm cylinder =
      form_of({.kind = ShapeKind::cylinder, .radius_m = 0.01, .length_m = 0.04, .edge_m = 1e-5});
  EXPECT_NEAR(cylinder.volume_m3, std::numbers::pi * 1e-4 * 0.04, 1e-9);
  EXPECT_NEAR(cylinder.inertia.principal_kgm2.z(), 0.5 * cylinder.inertia.mass_kg * 1e-4, 1e-9);
  EXPECT_LT(cylinder.frame.position_m.norm(), 1e-12);
  // A cone's centre of mass is a quarter of its height above the base.
  const BodyForm cone =
      form_of({.kind = ShapeKind::cone, .radius_m = 0.02, .length_m = 0.04, .edge_m = 1e-5});
  EXPECT_NEAR(cone.frame.position_m.z(), -0.02 + 0.01, 1e-4);
  // United States Bowling Congress: the centre of mass of a pin is 5.625 to 5.9375 in high.
  const BodyForm pin = form_of({.kind = ShapeKind::pin});
  EXPECT_GT(pin.frame.position_m.z(), 0.1428);
  EXPECT_LT(pin.frame.position_m.z(), 0.1509);
  EXPECT_NEAR(pin.inertia.mass_kg, 1000 * pin.volume_m3, 1e-12);
}

TEST(BodyForm, ACompoundOfRevolutionIsAxial) {
  const PartDescription stick{
      .sizes = {.kind = ShapeKind::cylinder, .radius_m = 0.002, .length_m = 0.1, .edge_m = 1e-4}};
  const PartDescription ball{.sizes = {.kind = ShapeKind::sphere, .radius_m = 0.015},
                             .pose = {.position_m = {0, 0, 0.05}}};
  const BodyForm lollipop =
      form_of({.kind = ShapeKind::compound}, std::vector<PartDescription>{stick, ball});
  EXPECT_EQ(lollipop.inertia.symmetry, physics::InertiaSymmetry::axial);
  EXPECT_EQ(lollipop.inertia.principal_kgm2.x(), lollipop.inertia.principal_kgm2.y());
  const double ball_kg = 1000 * 4 * std::numbers::pi / 3 * 0.015 * 0.015 * 0.015;
  EXPECT_NEAR(lollipop.frame.position_m.z(), 0.05 * ball_kg / lollipop.inertia.mass_kg, 1e-12);
}

TEST(Build, AStartIsThatOfTheShapesOrigin) {
  // The pin stands with its foot at the place, and its foot has the velocity.
  const BuiltScene built = built_scene(scene_of(R"(
[[world.body]]
name = "pin"
shape = "pin"
at_mm = [100, 0, 20]
turn_deg = [90, 0, 0]
velocity_mps = [0, 0, 1]
spin_radps = [0, 0, 10]
)"));
  const physics::BodyDescription& pin = built.scene.bodies.front();
  const double height_m = built.objects.front().frame.position_m.z();
  // A quarter turn about x leads z to -y.
  EXPECT_TRUE(pin.start.pose.position_m.isApprox(Vec3(0.1, -height_m, 0.02)));
  EXPECT_TRUE(pin.start.twist.velocity_mps.isApprox(Vec3(10 * height_m, 0, 1)));
}

TEST(Build, StaticElementsHaveTheirOwners) {
  // Compares with the names in the simulator's static geometry, in which a sphere and a box meet
  // features and pieces.
  const BuiltScene built = built_scene(scene_of(R"(
[[world.body]]
name = "ball"
radius_mm = 8
at_mm = [0, 0, 400]
[[world.body]]
name = "die"
shape = "box"
size_mm = [16, 16, 16]
at_mm = [99, 0, 400]
[[world.body]]
name = "sheet"
shape = "ramp"
radius_mm = 14
length_mm = 300
drop_mm = 20
row = {count = 2, step_mm = [0, 90, 0]}
[[world.body]]
name = "block"
shape = "compound"
static = true
part = [{shape = "box", size_mm = [9, 9, 9]}, {shape = "box", size_mm = [5, 5, 5], at_mm = [9, 0, 0]}]
[[world.body]]
name = "tent"
shape = "mesh"
points_mm = [[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]]
triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
[[world.body]]
name = "floor"
shape = "plane"
)"));
  const physics::StaticGeometry geometry(built.scene);
  const StaticOwners owners(built);
  const auto quoted = [&](std::uint32_t body, std::uint32_t met) {
    return "'" + built.objects[owners.owner(body, {met})].name + "'";
  };
  for (std::uint32_t i = 0; i < geometry.feature_count(); ++i)
    EXPECT_TRUE(geometry.name_of_feature({i}).ends_with(quoted(0, i))) << i;
  for (std::uint32_t i = 0; i < geometry.piece_count(); ++i)
    EXPECT_TRUE(geometry.name_of_piece({i}).ends_with(quoted(1, i))) << i;
}

TEST(Build, SlowContactsFollowFromTheSmallestBody) {
  const std::string marbles = "[[world.body]]\nname = \"a\"\nradius_mm = 8\n";
  const BuiltScene spheres = built_scene(scene_of(marbles));
  EXPECT_EQ(spheres.scene.slow.rest_speed_mps,
            physics::slow_contacts_of(0.016, 9.81).rest_speed_mps);
  const BuiltScene boxes = built_scene(scene_of("rest_s = 0.5\n" + marbles +
                                                "at_mm = [0, 0, 99]\n[[world.body]]\nname = "
                                                "\"b\"\nshape = \"box\"\nsize_mm = [8, 24, 48]\n"));
  EXPECT_EQ(boxes.scene.slow.separation_speed_mps,
            physics::coarse_slow_contacts_of(0.008, 9.81).separation_speed_mps);
  EXPECT_EQ(boxes.scene.slow.rest_time_s, 0.5);
}

TEST(Channel, AMarbleRunsDownAHelix) {
  const BuiltScene built = built_scene(scene_of(R"(
[[world.body]]
name = "marble"
radius_mm = 8
at_mm = [60, 3, -4]
[[world.body]]
name = "helix"
shape = "helix"
radius_mm = 14
path_radius_mm = 60
drop_mm = 150
turns = 3
)"));
  auto started = physics::Simulation::start(built.scene, {});
  ASSERT_TRUE(started.ok()) << started.error().message;
  physics::Simulation simulation = std::move(started).value();
  double turned_rad = 0;
  double before_rad = 0;
  for (int i = 1; i <= 300; ++i) {
    const auto error = simulation.run_until(physics::Tick{} + physics::ticks_after(0.01 * i));
    ASSERT_FALSE(error) << error->message;
    const Vec3 place_m = simulation.pose({0}, simulation.now()).position_m;
    if (place_m.z() < -0.15) break;
    const double r_m = std::hypot(place_m.x(), place_m.y());
    ASSERT_NEAR(r_m, 0.06, 0.014) << "the marble stays in the channel";
    const double angle_rad = std::atan2(place_m.y(), place_m.x());
    turned_rad += std::remainder(angle_rad - before_rad, 2 * std::numbers::pi);
    before_rad = angle_rad;
  }
  EXPECT_NEAR(turned_rad / (2 * std::numbers::pi), 3, 0.1) << "the marble has left at the end";
}

}  // namespace
}  // namespace sleight::worlds::user_scene
