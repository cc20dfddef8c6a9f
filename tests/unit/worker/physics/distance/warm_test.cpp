// Goal: what closest_warm remembers makes it faster, never different.
// Method: random trajectories with steps from 1e-6 to 0.5 of the size, some through one another;
// at each step warm against cold. Caches of other pairs and stale ones are thrown in.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/unit/worker/physics/distance/support.h"
#include "worker/physics/shape/shapes.h"

namespace sleight::physics {
namespace {

using math::norm;

void step(random::Stream& stream, double by, PlacedPose& pose, const Vec3& drift_m) {
  const Mat3 turn =
      math::matrix_of(math::quaternion_of_rotation_vector(2 * by * random_vector(stream)));
  Mat3 turned;
  for (int j = 0; j < 3; ++j)
    turned.col(j) = math::product(turn, pose.rotation.col(j));
  pose.rotation = turned;
  pose.position_m += by * random_vector(stream) + drift_m;
}

void expect_same(const Closest& warm, const Closest& cold, double coordinates, int at) {
  ASSERT_NEAR(warm.gap_m, cold.gap_m, 1e-14 * coordinates) << at;
  ASSERT_EQ(warm.overlapping(), cold.overlapping()) << at;
  ASSERT_LE(norm(warm.normal - cold.normal), 1e-13 * (1 + coordinates / std::fabs(cold.gap_m)))
      << at;
  if (warm.overlapping()) {
    ASSERT_EQ(warm.gap_m, cold.gap_m) << at;
  }
}

TEST(ClosestWarm, equals_cold_along_trajectories) {
  std::array<int, 4> searches{};
  int steps = 0;
  for (int i = 0; i < soaked(300); ++i) {
    random::Stream stream = numbers(401, static_cast<std::uint64_t>(i));
    const auto piece_a = random_piece(stream, 1);
    const auto piece_b = random_piece(stream, 1);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    Placement at = random_placement(stream, a, b, 1);
    const double by = log_between(stream, 1e-6, 0.5);
    SeparationCache cache;
    for (int k = 0; k < 200; ++k) {
      const Closest cold = closest_cold(a, at.a, b, at.b);
      const Closest warm = closest_warm(a, at.a, b, at.b, cache);
      const double coordinates = coordinates_m(a, at.a, b, at.b) + 2;
      ASSERT_NO_FATAL_FAILURE(expect_same(warm, cold, coordinates, 1000 * i + k));
      ++searches[static_cast<std::size_t>(warm.search)];
      ++steps;
      // Attracted where far, so that they meet; otherwise at random.
      const Vec3 drift = warm.gap_m > 0.2 ? Vec3(-0.5 * by * warm.normal) : Vec3(Vec3::Zero());
      step(stream, by, at.a, Vec3(Vec3::Zero()));
      step(stream, by, at.b, drift);
    }
  }
  std::printf("features %d, simplex %d, exhaustive %d, overlap %d\n", searches[0], searches[1],
              searches[2], searches[3]);
  EXPECT_GT(searches[0], steps / 3);
  EXPECT_GT(searches[3], 0);
}

// A cache from elsewhere costs time, not truth.
TEST(ClosestWarm, survives_any_cache) {
  for (int i = 0; i < 5000; ++i) {
    random::Stream stream = numbers(402, static_cast<std::uint64_t>(i));
    const auto piece_a = random_piece(stream, 1);
    const auto piece_b = random_piece(stream, 1);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    const Placement at = random_placement(stream, a, b, 1);
    const auto any_feature = [&](const ConvexView& piece) {
      const auto kind = static_cast<FeatureKind>(stream.bits() % 3);
      const std::uint16_t count = kind == FeatureKind::vertex ? piece.vertex_count
                                  : kind == FeatureKind::edge ? piece.edge_count
                                                              : piece.face_count;
      return Feature{kind, static_cast<std::uint16_t>(stream.bits() % count)};
    };
    SeparationCache cache{.axis = random_unit(stream), .a = {}, .b = {}, .filled = true};
    cache.a = any_feature(a);
    cache.b = any_feature(b);
    const Closest cold = closest_cold(a, at.a, b, at.b);
    const Closest warm = closest_warm(a, at.a, b, at.b, cache);
    ASSERT_NO_FATAL_FAILURE(expect_same(warm, cold, coordinates_m(a, at.a, b, at.b) + 2, i));
  }
}

}  // namespace
}  // namespace sleight::physics
