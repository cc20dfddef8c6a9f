// Goal: two results are right: the furthest vertex in a direction, and the lower bound of the gap
// along an axis. Method: compare both with plain loops over all vertices, in long double where
// rounding matters.
#include "worker/physics/distance/separation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/property.h"
#include "tests/unit/worker/physics/distance/support.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

TEST(FurthestVertex, is_the_first_of_the_furthest) {
  for (const std::uint64_t i : property::cases(2000)) {
    random::Stream stream = numbers(301, i);
    const auto piece = random_piece(stream, 1);
    const ConvexView view = piece->view();
    for (int k = 0; k < 20; ++k) {
      // Directions along axes cause ties on cubes and prisms.
      Vec3 direction = random_unit(stream);
      if (k % 4 == 0) direction = Vec3(0, 0, k % 8 == 0 ? 1 : -1);
      std::size_t first = 0;
      for (std::size_t v = 1; v < view.vertex_count; ++v) {
        if (math::dot(direction, view.vertices_m[v]) > math::dot(direction, view.vertices_m[first]))
          first = v;
      }
      ASSERT_EQ(furthest_vertex(view, direction), first) << i;
      const auto start = static_cast<std::uint16_t>(stream.bits() % view.vertex_count);
      ASSERT_NEAR(math::dot(direction, view.vertices_m[climbed_vertex(view, direction, start)]),
                  math::dot(direction, view.vertices_m[first]), 1e-15)
          << i;
    }
  }
}

long double shadow(const ConvexView& piece, const PlacedPose& pose, const Vec3& axis,
                   const Vec3& origin, bool greatest) {
  long double best = greatest ? -INFINITY : INFINITY;
  for (std::size_t v = 0; v < piece.vertex_count; ++v) {
    long double sum = 0;
    for (int i = 0; i < 3; ++i) {
      long double x = static_cast<long double>(pose.position_m[i]) - origin[i];
      for (int j = 0; j < 3; ++j)
        x += static_cast<long double>(pose.rotation(i, j)) * piece.vertices_m[v][j];
      sum += axis[i] * x;
    }
    best = greatest ? std::max(best, sum) : std::min(best, sum);
  }
  return best;
}

TEST(SeparationAlong, is_a_bound_of_the_gap_and_errs_by_less_than_it_says) {
  for (const std::uint64_t i : property::cases(3000)) {
    random::Stream stream = numbers(302, i);
    const double size = log_between(stream, 1e-3, 1e2);
    const auto piece_a = random_piece(stream, size);
    const auto piece_b = random_piece(stream, size);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    const Placement at = random_placement(stream, a, b, size);
    const Closest closest = closest_cold(a, at.a, b, at.b);
    for (int k = 0; k < 10; ++k) {
      const Vec3 axis = k == 0 ? closest.normal : random_unit(stream);
      const double bound = separation_along(axis, a, at.a, b, at.b);
      const double error = separation_error_m(a, at.a, b, at.b);
      const Vec3& origin = at.a.position_m;
      const long double exact =
          shadow(b, at.b, axis, origin, false) - shadow(a, at.a, axis, origin, true);
      ASSERT_LE(std::fabs(static_cast<double>(bound - exact)), error) << i;
      ASSERT_LE(bound - error, closest.gap_m + error) << i;
    }
  }
}

}  // namespace
}  // namespace sleight::physics
