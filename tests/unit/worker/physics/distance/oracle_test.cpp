// Goal: closest_cold() agrees with an independent implementation on 100,000 pairs. Method: compare
// the gap with the distance that FCL 0.7 computes between convex meshes. FCL uses GJK in double,
// with libccd's supports, and stops at a threshold of 1e-9. FCL's gap is an upper bound. For sizes
// of about 1, FCL's error is at most the threshold. This test therefore uses pieces of size 1 and a
// tolerance of ten thresholds. FCL may report a touch for gaps below 1e-6, so this test skips them;
// the long double reference covers them. FCL is wrong for a few pairs in 10,000, because its GJK
// stops early on nearly degenerate simplices. If the two gaps differ, the long double reference
// must agree with closest_cold(). Fewer than one pair in 1000 may differ.
#include <fcl/geometry/shape/convex.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/distance/support.h"

namespace sleight::physics {
namespace {

std::shared_ptr<fcl::Convexd> oracle_piece(const Piece& piece) {
  const ConvexView view = piece.view();
  auto vertices = std::make_shared<std::vector<fcl::Vector3d>>(view.vertices_m,
                                                               view.vertices_m + view.vertex_count);
  auto faces = std::make_shared<std::vector<int>>();
  for (std::size_t f = 0; f < view.face_count; ++f) {
    faces->push_back(view.faces[f].side_count);
    for (int k = 0; k < view.faces[f].side_count; ++k)
      faces->push_back(view.sides[view.faces[f].first_side + k].vertex);
  }
  return std::make_shared<fcl::Convexd>(vertices, view.face_count, faces);
}

fcl::Transform3d oracle_pose(const PlacedPose& pose) {
  fcl::Transform3d result = fcl::Transform3d::Identity();
  result.linear() = pose.rotation;
  result.translation() = pose.position_m;
  return result;
}

TEST(Oracle, fcl_finds_the_same_gap) {
  constexpr double k_threshold = 1e-9;
  fcl::DistanceRequestd request(false, false, 0, 0, k_threshold, fcl::GST_LIBCCD);
  int compared = 0;
  int different = 0;
  const std::uint64_t pairs = soaked(700);
  for (const std::uint64_t i : property::cases(pairs)) {
    random::Stream stream = numbers(501, i);
    const auto piece_a = random_piece(stream, 1);
    const auto piece_b = random_piece(stream, log_between(stream, 0.3, 3));
    const auto oracle_a = oracle_piece(*piece_a);
    const auto oracle_b = oracle_piece(*piece_b);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    for (int k = 0; k < 250; ++k) {
      const Placement at = random_placement(stream, a, b, 1);
      const Closest ours = closest_cold(a, at.a, b, at.b);
      if (ours.gap_m < 1e-6) continue;
      fcl::DistanceResultd result;
      const double theirs = fcl::distance<double>(oracle_a.get(), oracle_pose(at.a), oracle_b.get(),
                                                  oracle_pose(at.b), request, result);
      ++compared;
      if (std::fabs(theirs - ours.gap_m) <= 10 * k_threshold) continue;
      ++different;
      const auto exact = static_cast<double>(reference_gap(a, at.a, b, at.b));
      ASSERT_NEAR(ours.gap_m, exact, 1e-14 * (coordinates_m(a, at.a, b, at.b) + 2))
          << i << ' ' << k << ": FCL says " << theirs;
    }
  }
  if (!property::all_cases()) return;
  std::printf("compared %d, FCL wrong in %d\n", compared, different);
  EXPECT_LT(different, compared / 1000);
  EXPECT_GT(compared, pairs * 145);
}

}  // namespace
}  // namespace sleight::physics
