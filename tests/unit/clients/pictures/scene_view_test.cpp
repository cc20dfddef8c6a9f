// Goal: a die is drawn in its pose, with the right outline, numbers and pips. Method: draw dice in
// known poses.
#include "clients/pictures/scene_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clients/shapes/facets.h"

namespace sleight::pictures {
namespace {

using math::Quat;
using math::Vec3;
using ::testing::ElementsAre;

Quat turned(const Vec3& axis, double angle_deg) {
  return math::quaternion_of_rotation_vector(axis * (angle_deg * M_PI / 180));
}

std::vector<FlatPiece> seen_faces(const motion::Pose& pose, double side_mm, Seen seen) {
  scene::Part die{.shape = scene::Shape::die, .size_m = Vec3::Constant(side_mm / k_mm_per_m)};
  std::vector<FlatPiece> faces = flat_pieces({}, die, pose, seen, {});
  std::ranges::sort(faces, {}, &FlatPiece::face);
  return faces;
}

std::vector<std::uint32_t> numbers_of(const std::vector<FlatPiece>& faces) {
  std::vector<std::uint32_t> numbers;
  for (const FlatPiece& face : faces)
    numbers.push_back(face.face);
  return numbers;
}

plot::Point middle_of(const auto& corners) {
  plot::Point middle;
  for (const plot::Point& corner : corners) {
    middle.x += corner.x / static_cast<double>(corners.size());
    middle.y += corner.y / static_cast<double>(corners.size());
  }
  return middle;
}

double area_of(const auto& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const plot::Point& a = corners[i];
    const plot::Point& b = corners[(i + 1) % corners.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return std::abs(twice) / 2;
}

TEST(SceneView, ADieThatIsNotTurnedShowsItsThree) {
  // Goal: a die without rotation has face 3 on top and face 5 in front (face 1 on +x, face 2 on
  // +y). Method: view the die from above and from the front. Each corner of the upper face must be
  // half a side from the face's centre along x and along y.
  const motion::Pose pose{.centre_m = {0.010, 0.020, 0.008}};
  const auto above = seen_faces(pose, 16, Seen::from_above);
  ASSERT_THAT(numbers_of(above), ElementsAre(3));
  for (const plot::Point& corner : above[0].corners_mm) {
    EXPECT_DOUBLE_EQ(std::abs(corner.x - 10), 8);
    EXPECT_DOUBLE_EQ(std::abs(corner.y - 20), 8);
  }
  EXPECT_DOUBLE_EQ(area_of(above[0].corners_mm), 256);
  const auto front = seen_faces(pose, 16, Seen::from_front);
  ASSERT_THAT(numbers_of(front), ElementsAre(5));
  EXPECT_NEAR(middle_of(front[0].corners_mm).x, 10, 1e-12);
  EXPECT_NEAR(middle_of(front[0].corners_mm).y, 8, 1e-12);
}

TEST(SceneView, EveryFaceComesUp) {
  // Goal: each face of a die can be turned up and shows its number of pips. The numbers of opposite
  // faces add up to 7. Method: make quarter turns about x and y.
  const std::vector<std::pair<Quat, std::uint32_t>> poses{
      {turned({0, 1, 0}, -90), 1}, {turned({1, 0, 0}, 90), 2},  {turned({1, 0, 0}, 0), 3},
      {turned({1, 0, 0}, 180), 4}, {turned({1, 0, 0}, -90), 5}, {turned({0, 1, 0}, 90), 6}};
  for (const auto& [orientation, face] : poses) {
    EXPECT_EQ(shapes::upper_face(orientation), face);
    const auto seen = seen_faces({.orientation = orientation}, 16, Seen::from_above);
    ASSERT_THAT(numbers_of(seen), ElementsAre(face));
    EXPECT_EQ(seen[0].pips_mm.size(), face);
    const Quat over = math::composed(turned({1, 0, 0}, 180), orientation);
    EXPECT_EQ(shapes::upper_face(over), 7 - face);
  }
}

TEST(SceneView, OneTwoThreeGoRoundAnticlockwise) {
  // Goal: the numbering is not mirrored. Method: turn the die so that the corner of faces 1, 2 and
  // 3 points up. From above, the middles of these faces must be in anticlockwise order.
  const Vec3 axis = Vec3(1, -1, 0) / std::sqrt(2.0);
  const Quat corner_up = turned(axis, std::acos(1 / std::sqrt(3.0)) * 180 / M_PI);
  const auto seen = seen_faces({.orientation = corner_up}, 16, Seen::from_above);
  ASSERT_THAT(numbers_of(seen), ElementsAre(1, 2, 3));
  for (std::size_t i = 0; i < 3; ++i) {
    const plot::Point a = middle_of(seen[i].corners_mm);
    const plot::Point b = middle_of(seen[(i + 1) % 3].corners_mm);
    EXPECT_GT(a.x * b.y - b.x * a.y, 0) << i;
    EXPECT_NEAR(area_of(seen[i].corners_mm), 256 / std::sqrt(3.0), 1e-9);
  }
}

TEST(SceneView, OutlineOfATiltedDie) {
  // Goal: a tilted die shows two faces, each foreshortened by the cosine of its tilt. Method: turn
  // the die about y, so that face 6 (on -x) appears beside face 3.
  for (const double angle_deg : {20.0, 45.0, 70.0}) {
    const double angle = angle_deg * M_PI / 180;
    const auto seen =
        seen_faces({.orientation = turned({0, 1, 0}, angle_deg)}, 10, Seen::from_above);
    ASSERT_THAT(numbers_of(seen), ElementsAre(3, 6));
    EXPECT_NEAR(area_of(seen[0].corners_mm), 100 * std::cos(angle), 1e-9);
    EXPECT_NEAR(area_of(seen[1].corners_mm), 100 * std::sin(angle), 1e-9);
  }
}

TEST(SceneView, PipsLieApartWithinTheirFace) {
  // Goal: a face's pips are inside the face, don't overlap, and are symmetric about the face's
  // middle.
  for (std::uint32_t face = 1; face <= 6; ++face) {
    const Quat up = face == 1   ? turned({0, 1, 0}, -90)
                    : face == 6 ? turned({0, 1, 0}, 90)
                    : face == 2 ? turned({1, 0, 0}, 90)
                    : face == 5 ? turned({1, 0, 0}, -90)
                                : turned({1, 0, 0}, face == 3 ? 0 : 180);
    const auto seen = seen_faces({.orientation = up}, 2, Seen::from_above);
    ASSERT_EQ(seen.size(), 1U);
    plot::Point sum;
    std::vector<plot::Point> middles;
    for (const auto& pip : seen[0].pips_mm) {
      for (const plot::Point& corner : pip)
        EXPECT_LT(std::max(std::abs(corner.x), std::abs(corner.y)), 0.9);
      const plot::Point middle = middle_of(pip);
      for (const plot::Point& other : middles)
        EXPECT_GT(std::hypot(middle.x - other.x, middle.y - other.y), 0.45);
      middles.push_back(middle);
      sum.x += middle.x;
      sum.y += middle.y;
    }
    EXPECT_NEAR(sum.x, 0, 1e-12);
    EXPECT_NEAR(sum.y, 0, 1e-12);
  }
}

}  // namespace
}  // namespace sleight::pictures
