// Tests where the edges of two pieces cross while one piece lies on the other.
#include "worker/physics/collision/piece_corners.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "common/math/rotation.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

constexpr double k_near_m = 1e-6;

/// Returns where the edges of two cubes of side 1 cross. The upper cube lies turned and shifted on
/// the lower cube, at height 1.
std::vector<Vec3> crossings(double yaw_rad, const Vec3& aside_m) {
  const ConvexPolyhedron solid = cube(1).value();
  const ConvexView view = solid.view();
  const auto piece_at = [&](const Vec3& centre_m, double turned_rad) {
    MovingPiece piece;
    piece.view = &view;
    piece.pose = {
        .rotation = math::matrix_of(math::quaternion_of_rotation_vector({0, 0, turned_rad})),
        .position_m = centre_m};
    return piece;
  };
  std::vector<Vec3> found;
  for_each_crossing(piece_at({0, 0, 0.5}, 0), piece_at(aside_m + Vec3(0, 0, 1.5), yaw_rad),
                    {0, 0, 1}, 1, k_near_m, [&](const Vec3& at_m) { found.push_back(at_m); });
  return found;
}

TEST(PieceCorners, EdgesCrossWhereFacesLieAskew) {
  // Goal: the edge crossings of two pieces are the corners of their common area. Corners that
  // belong to one of the pieces don't count. Method: put a cube on another cube. The cubes' edges
  // cross eight times, twice, or only at their ends. Also hold the upper cube slightly too high.
  const double r = 0.5;
  const std::vector<Vec3> eight = crossings(std::numbers::pi / 4, Vec3::Zero());
  EXPECT_EQ(eight.size(), 8U);
  for (const Vec3& at_m : eight) {
    // The crossings are where the upper cube's edges, |x| + |y| = sqrt(2) r, cross the lower cube's
    // rim.
    EXPECT_NEAR(at_m.cwiseAbs().head<2>().maxCoeff(), r, 1e-12);
    EXPECT_NEAR(at_m.cwiseAbs().head<2>().sum(), std::numbers::sqrt2 * r, 1e-12);
    EXPECT_NEAR(at_m.z(), 1, 1e-12);
  }
  EXPECT_EQ(crossings(0, {0.25, 0.125, 0}).size(), 2U);
  EXPECT_EQ(crossings(0, Vec3::Zero()).size(), 0U);
  EXPECT_EQ(crossings(0, {0.25, 0, 0}).size(), 0U);
  EXPECT_EQ(crossings(1e-9, {0.25, 0, 0}).size(), 0U);
  EXPECT_EQ(crossings(std::numbers::pi / 4, {0, 0, 2 * k_near_m}).size(), 0U);
}

}  // namespace
}  // namespace sleight::physics
