#include "worker/worlds/dice/numbering.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "tests/unit/worker/worlds/dice/support.h"

namespace sleight::worlds::dice {
namespace {

TEST(Numbering, IsThatOfADie) {
  // Goal: in numbering 0, opposite faces add up to 7, and faces 1, 2 and 3 are anticlockwise seen
  // from outside. Method: compare the normals of opposite faces, and compute the triple product of
  // the normals of faces 1, 2 and 3.
  const auto normal = [](std::uint32_t face) {
    return testing::vector_of(direction_of_face(face, 0));
  };
  for (std::uint32_t face = 1; face <= 6; ++face)
    EXPECT_EQ(normal(face), Vec3(-normal(7 - face))) << face;
  EXPECT_EQ(math::dot(math::cross(normal(1), normal(2)), normal(3)), 1);
  EXPECT_EQ(normal(1), Vec3(1, 0, 0));
}

TEST(Numbering, RotationsAreAllTwentyFour) {
  // Goal: the 24 numberings have distinct rotations, which move the faces as the table of faces
  // states. Method: rotate each face's normal in numbering 0 by the rotation of numbering s, and
  // compare with the face's normal in numbering s.
  std::set<std::vector<int>> seen;
  for (std::uint32_t s = 0; s < k_numberings; ++s) {
    const Quat q = rotation_of_numbering(s);
    EXPECT_NEAR(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z(), 1, 1e-15) << s;
    std::vector<int> faces;
    for (std::uint32_t face = 1; face <= 6; ++face) {
      const AxisDirection direction = direction_of_face(face, s);
      const Vec3 turned = math::rotated(q, testing::vector_of(direction_of_face(face, 0)));
      EXPECT_LT(math::norm(Vec3(turned - testing::vector_of(direction))), 1e-15)
          << s << " " << face;
      faces.push_back(direction.sign * (direction.axis + 1));
    }
    seen.insert(faces);
  }
  EXPECT_EQ(seen.size(), 24U);
  EXPECT_EQ(rotation_of_numbering(0).coeffs(), Quat::Identity().coeffs());
}

TEST(Numbering, OrientationsHaveTheirFaceUp) {
  // Goal: orientation_with_face_up() turns the requested face to the top, at any yaw.
  for (std::uint32_t face = 1; face <= 6; ++face) {
    for (const double yaw_rad : {0.0, 1.0, -2.5}) {
      const Quat q = orientation_with_face_up(face, yaw_rad);
      const Vec3 normal = math::rotated(q, testing::vector_of(direction_of_face(face, 0)));
      EXPECT_NEAR(normal.z(), 1, 1e-15) << face << " " << yaw_rad;
    }
  }
}

}  // namespace
}  // namespace sleight::worlds::dice
