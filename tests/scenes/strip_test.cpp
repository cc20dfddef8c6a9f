// Outlines of bodies and strips of scenes.
#include "tests/scenes/strip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "common/math/rotation.h"
#include "common/math/vector.h"
#include "tests/scenes/outline.h"
#include "worker/physics/shape/round_solids.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::scene_pictures {
namespace {

using physics::Vec3;

/// How far an outline reaches along a direction of the picture.
double reach_m(const Look& look, double right, double up) {
  double most = -1e300;
  for (const Patch& patch : look.patches) {
    for (const plot::Point& at_m : patch.outline_m)
      most = std::max(most, right * at_m.x + up * at_m.y);
  }
  return most;
}

TEST(ScenePictures, OutlinesReachAsFarAsBodies) {
  // Goal: what is drawn is what is there. Method: an outline's reach in the picture is the body's
  // along that direction: of a cylinder by hand, of a cube by its corners.
  const Camera camera(0.4, 0.3);
  const physics::Pose pose{.position_m = {0.1, -0.2, 0.3},
                           .orientation = math::quaternion_of_rotation_vector({0.3, 0.7, -0.2})};
  const physics::RoundSolid solid = physics::cylinder(0.04, 0.1, 0.001, 1000).value();
  const auto round = std::make_shared<const physics::Compound>(
      physics::Compound{.parts = {}, .round_parts = solid.parts});
  const auto cubic = std::make_shared<const physics::Compound>(
      physics::Compound{.parts = {physics::cube(0.1).value()}});
  const Look cylinder = look_of(round, pose, camera);
  const Look cube = look_of(cubic, pose, camera);
  for (int i = 0; i < 12; ++i) {
    const double right = std::cos(0.5235987755982988 * i);
    const double up = std::sin(0.5235987755982988 * i);
    const Vec3 direction = camera.seen_as(right, up);
    const double centre_m = math::dot(direction, pose.position_m);
    const Vec3 local = math::rotated(math::inverse(pose.orientation), direction);
    const double across = std::sqrt(local.x() * local.x() + local.y() * local.y());
    // Rounded edges of a millimetre.
    EXPECT_NEAR(reach_m(cylinder, right, up) - centre_m,
                0.039 * across + 0.049 * std::fabs(local.z()) + 0.001, 1e-4);
    EXPECT_NEAR(reach_m(cube, right, up) - centre_m,
                0.05 * (std::fabs(local.x()) + std::fabs(local.y()) + std::fabs(local.z())), 1e-9);
  }
}

TEST(ScenePictures, AStripShowsEachBodyAtEachMoment) {
  // Goal: nothing is left out. Method: numbers of elements of a strip of discs and of one of cubes.
  const auto count = [](const std::string& text, const std::string& what) {
    std::size_t found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
      ++found;
    return found;
  };
  physics::scenes::Setting spheres = physics::scenes::boxed_spheres(7, 1);
  spheres.duration_s = 0.2;
  const Strip discs = strip_of(spheres, "seven spheres");
  EXPECT_EQ(discs.error, "");
  EXPECT_EQ(discs.bodies_drawn, 7 * k_moments);
  EXPECT_EQ(count(discs.svg, "<circle"), 2 * 7 * k_moments);
  EXPECT_NE(discs.svg.find("seven spheres"), std::string::npos);
  physics::scenes::Setting cubes = physics::scenes::cube_stack(3, 1);
  cubes.duration_s = 0.1;
  const Strip stack = strip_of(cubes, "three cubes");
  EXPECT_EQ(stack.bodies_drawn, 3 * k_moments);
  // Two or three faces of each, and the floor.
  EXPECT_GE(count(stack.svg, "<polygon"), (2 * 3 + 1) * k_moments);
  EXPECT_LE(count(stack.svg, "<polygon"), (3 * 3 + 1) * k_moments);
}

}  // namespace
}  // namespace sleight::scene_pictures
