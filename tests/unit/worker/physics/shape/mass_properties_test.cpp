// Goal: the mass, centre of mass, inertia, principal axes and frame of a body are right. Method:
// for boxes, prisms and tetrahedra, compare these properties with closed forms. A body that is cut
// into parts and turned must give the same result. A wrongly declared symmetry must give an error.
#include "worker/physics/shape/mass_properties.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/random/stream.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using math::norm;
using math::product;
using math::rotated;
using Parts = std::vector<ConvexPolyhedron>;

random::Stream numbers(std::uint64_t test, std::uint64_t index) {
  return random::Stream({.seed = test, .purpose = random::Purpose::prior}, index);
}

Vec3 random_vector(random::Stream& stream) {
  const double x = 2 * stream.uniform() - 1;
  const double y = 2 * stream.uniform() - 1;
  return {x, y, 2 * stream.uniform() - 1};
}

Mat3 random_rotation(random::Stream& stream) {
  return math::matrix_of(math::quaternion_of_rotation_vector(3 * random_vector(stream)));
}

double largest(const Mat3& m) {
  return m.cwiseAbs().maxCoeff();
}

TEST(MassProperties, of_known_solids) {
  // Box: m/12 (b^2 + c^2). Tetrahedron: m s^2 / 20. Hexagonal prism about its axis: m (5/12) s^2.
  const Parts boxes{box(Vec3(1, 2, 3)).value()};
  const MassProperties b = mass_properties(boxes, 2);
  EXPECT_NEAR(b.volume_m3, 6, 1e-14);
  EXPECT_NEAR(b.mass_kg, 12, 3e-14);
  EXPECT_LT(norm(b.centre_m), 1e-15);
  const Mat3 expected = Vec3(13, 10, 5).asDiagonal();
  EXPECT_LT(largest(b.inertia_kgm2 - expected), 3e-14);
  const double side = 2 * std::sqrt(2.0);
  const MassProperties t = mass_properties(Parts{tetrahedron(std::sqrt(3.0)).value()}, 1);
  EXPECT_LT(largest(t.inertia_kgm2 - t.mass_kg * side * side / 20 * Mat3::Identity()), 1e-14);
  const MassProperties p = mass_properties(Parts{regular_prism(6, 1, 2).value()}, 1);
  EXPECT_NEAR(p.inertia_kgm2(2, 2), p.mass_kg * 5 / 12, 1e-14);
}

TEST(MassProperties, of_parts_are_those_of_the_whole) {
  // A box cut into eight unequal boxes, then turned and shifted as a whole.
  random::Stream stream = numbers(12, 0);
  for (int i = 0; i < 50; ++i) {
    const Vec3 sides(1, 2, 3);
    const Vec3 cut(0.3, 1.1, 0.4);
    const Mat3 turn = random_rotation(stream);
    const Vec3 shift = 3 * random_vector(stream);
    Parts parts;
    for (int k = 0; k < 8; ++k) {
      Vec3 low = Vec3::Zero();
      Vec3 size = cut;
      for (int axis = 0; axis < 3; ++axis) {
        if ((k >> axis & 1) == 0) continue;
        low[axis] = cut[axis];
        size[axis] = sides[axis] - cut[axis];
      }
      const Vec3 middle = low + 0.5 * size - 0.5 * sides;
      parts.push_back(moved(box(size).value(), turn, product(turn, middle) + shift));
    }
    const MassProperties whole = mass_properties(Parts{moved(box(sides).value(), turn, shift)}, 2);
    const MassProperties sum = mass_properties(parts, 2);
    ASSERT_NEAR(sum.mass_kg, 12, 1e-13);
    ASSERT_LT(norm(sum.centre_m - shift), 1e-14);
    ASSERT_LT(largest(sum.inertia_kgm2 - whole.inertia_kgm2), 1e-12);
    // in_body_frame recovers the whole box.
    const auto body = in_body_frame(parts, 2, InertiaSymmetry::general);
    ASSERT_TRUE(body.ok());
    std::array<double, 3> moments{};
    for (int axis = 0; axis < 3; ++axis)
      moments[static_cast<std::size_t>(axis)] = body.value().inertia.principal_kgm2[axis];
    std::sort(moments.begin(), moments.end());
    ASSERT_NEAR(moments[0], 5, 1e-12);
    ASSERT_NEAR(moments[1], 10, 1e-12);
    ASSERT_NEAR(moments[2], 13, 1e-12);
    const MassProperties again = mass_properties(body.value().parts, 2);
    ASSERT_LT(norm(again.centre_m), 1e-14);
    const Mat3 diagonal = body.value().inertia.principal_kgm2.asDiagonal();
    ASSERT_LT(largest(again.inertia_kgm2 - diagonal), 1e-12);
    // The frame maps the body's vertices back to their initial places.
    const Pose& frame = body.value().frame;
    for (std::size_t v = 0; v < 8; ++v) {
      const Vec3 back =
          rotated(frame.orientation, body.value().parts[0].vertices_m()[v]) + frame.position_m;
      ASSERT_LT(norm(back - parts[0].vertices_m()[v]), 1e-14);
    }
  }
}

TEST(PrincipalAxes, diagonalise_and_stay_close_to_the_frame) {
  random::Stream stream = numbers(13, 0);
  for (int i = 0; i < 2000; ++i) {
    const Mat3 turn = random_rotation(stream);
    Vec3 moments = random_vector(stream).cwiseAbs() + Vec3(0.1, 0.1, 0.1);
    if (i % 3 == 0) moments[1] = moments[0] * (1 + 1e-12 * stream.uniform());
    const Mat3 matrix = turn * moments.asDiagonal() * turn.transpose();
    const PrincipalAxes found = principal_axes(matrix);
    ASSERT_LT(largest(found.axes * found.moments.asDiagonal() * found.axes.transpose() - matrix),
              1e-14);
    ASSERT_LT(largest(found.axes.transpose() * found.axes - Mat3::Identity()), 1e-14);
    ASSERT_NEAR(found.axes.determinant(), 1, 1e-14);
  }
  const Mat3 diagonal = Vec3(3, 1, 2).asDiagonal();
  const PrincipalAxes same = principal_axes(diagonal);
  EXPECT_EQ(same.axes, Mat3(Mat3::Identity()));
  EXPECT_EQ(same.moments, Vec3(3, 1, 2));
}

TEST(InBodyFrame, makes_declared_moments_exactly_equal) {
  random::Stream stream = numbers(14, 0);
  for (int i = 0; i < 50; ++i) {
    const Mat3 turn = random_rotation(stream);
    const Vec3 shift = random_vector(stream);
    const Parts ball{moved(icosphere(1, 1).value(), turn, shift)};
    const auto body = in_body_frame(ball, 3, InertiaSymmetry::spherical);
    ASSERT_TRUE(body.ok());
    const Vec3& m = body.value().inertia.principal_kgm2;
    ASSERT_EQ(m[0], m[1]);
    ASSERT_EQ(m[1], m[2]);
    ASSERT_EQ(body.value().frame.orientation.w(), 1);
    // In the body's frame, a prism's axis is along z.
    const Parts top{moved(regular_prism(5, 1, 3).value(), turn, shift)};
    const auto spun = in_body_frame(top, 3, InertiaSymmetry::axial);
    ASSERT_TRUE(spun.ok());
    const Vec3& s = spun.value().inertia.principal_kgm2;
    ASSERT_EQ(s[0], s[1]);
    ASSERT_LT(s[2], s[0]);
    double top_z = -9;
    for (const Vec3& v : spun.value().parts[0].vertices_m())
      top_z = std::max(top_z, v.z());
    ASSERT_NEAR(top_z, 1.5, 1e-14);
    ASSERT_NEAR(norm(product(turn, Vec3(0, 0, 1)) -
                     rotated(spun.value().frame.orientation, Vec3(0, 0, 1))) *
                    norm(product(turn, Vec3(0, 0, 1)) +
                         rotated(spun.value().frame.orientation, Vec3(0, 0, 1))),
                0, 1e-13);
  }
  // An upright prism keeps its frame, and a cube that is declared axial keeps its frame too.
  const auto upright =
      in_body_frame(Parts{regular_prism(6, 1, 3).value()}, 1, InertiaSymmetry::axial);
  EXPECT_LT(norm(rotated(upright.value().frame.orientation, Vec3(1, 0, 0)) - Vec3(1, 0, 0)), 1e-12);
  const auto die = in_body_frame(Parts{cube(1).value()}, 1, InertiaSymmetry::axial);
  EXPECT_LT(norm(rotated(die.value().frame.orientation, Vec3(0, 0, 1)) - Vec3(0, 0, 1)), 1e-12);
}

TEST(InBodyFrame, refuses_what_is_declared_wrongly) {
  const Parts brick{box(Vec3(1, 2, 3)).value()};
  const auto kind = [](const auto& result) { return result.error().kind; };
  using Kind = ShapeError::Kind;
  EXPECT_EQ(kind(in_body_frame(brick, 1, InertiaSymmetry::spherical)), Kind::not_spherical);
  EXPECT_EQ(kind(in_body_frame(brick, 1, InertiaSymmetry::axial)), Kind::not_axial);
  EXPECT_EQ(kind(in_body_frame(brick, 0, InertiaSymmetry::general)), Kind::dimension_not_positive);
  EXPECT_EQ(kind(in_body_frame({}, 1, InertiaSymmetry::general)), Kind::no_parts);
  // The first box's moments differ by slightly more than the tolerance. The second box's moments
  // differ by slightly less.
  const auto nearly = [](double by) { return Parts{box(Vec3(1, 1, 1 + by)).value()}; };
  EXPECT_FALSE(in_body_frame(nearly(3e-9), 1, InertiaSymmetry::spherical).ok());
  EXPECT_TRUE(in_body_frame(nearly(3e-10), 1, InertiaSymmetry::spherical).ok());
}

TEST(SolidSphere, has_its_textbook_inertia) {
  // I = 2/5 m r^2 with m = 4/3 pi r^3 times 3. A fine icosphere has slightly less mass and moment.
  const Inertia sphere = solid_ball_inertia(100.530964914873, 2);
  EXPECT_NEAR(sphere.principal_kgm2.x(), 160.849543863797, 1e-11);
  const MassProperties fine = mass_properties(Parts{icosphere(2, 3).value()}, 3);
  EXPECT_LT(fine.mass_kg, sphere.mass_kg);
  EXPECT_GT(fine.mass_kg, 0.98 * sphere.mass_kg);
  EXPECT_LT(fine.inertia_kgm2(0, 0), sphere.principal_kgm2.x());
  EXPECT_GT(fine.inertia_kgm2(0, 0), 0.96 * sphere.principal_kgm2.x());
}

}  // namespace
}  // namespace sleight::physics
