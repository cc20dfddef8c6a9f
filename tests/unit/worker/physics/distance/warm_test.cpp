// Goal: neither a cache (closest_warm) nor a hint (closest_cold) changes the result of a search.
// Method: compare closest_warm with closest_cold at each step of random trajectories. Steps are
// 1e-6 to 0.5 of the size, and some pieces pass through each other. Also try caches with random
// contents.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tests/support/property.h"
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

void expect_same(const Closest& warm, const Closest& cold, double coordinates, std::uint64_t at) {
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
  for (const std::uint64_t i : property::cases(soaked(300))) {
    random::Stream stream = numbers(401, i);
    const auto piece_a = random_piece(stream, 1);
    const auto piece_b = random_piece(stream, 1);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    Placement at = random_placement(stream, a, b, 1);
    const double by = log_between(stream, 1e-6, 0.5);
    SeparationCache cache;
    for (std::uint64_t k = 0; k < 200; ++k) {
      const Closest cold = closest_cold(a, at.a, b, at.b);
      const Closest warm = closest_warm(a, at.a, b, at.b, cache);
      const double coordinates = coordinates_m(a, at.a, b, at.b) + 2;
      ASSERT_NO_FATAL_FAILURE(expect_same(warm, cold, coordinates, 1000 * i + k));
      ++searches[static_cast<std::size_t>(warm.search)];
      ++steps;
      // Distant pieces attract each other so that they meet. Close pieces drift randomly.
      const Vec3 drift = warm.gap_m > 0.2 ? Vec3(-0.5 * by * warm.normal) : Vec3(Vec3::Zero());
      step(stream, by, at.a, Vec3(Vec3::Zero()));
      step(stream, by, at.b, drift);
    }
  }
  if (!property::all_cases()) return;
  std::printf("features %d, simplex %d, exhaustive %d, overlap %d\n", searches[0], searches[1],
              searches[2], searches[3]);
  EXPECT_GT(searches[0], steps / 3);
  EXPECT_GT(searches[3], 0);
}

// A wrong cache costs time but doesn't change the result.
TEST(ClosestWarm, survives_any_cache) {
  for (const std::uint64_t i : property::cases(property::of_tier(1500, 5000))) {
    random::Stream stream = numbers(402, i);
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

// ---- closest_cold with a hint -------------------------------------------------------------------

bool same_bits(double x, double y) {
  return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
}

bool same_bits(const Vec3& x, const Vec3& y) {
  return same_bits(x.x(), y.x()) && same_bits(x.y(), y.y()) && same_bits(x.z(), y.z());
}

void expect_same_bits(const Closest& hinted, const Closest& plain) {
  ASSERT_TRUE(same_bits(hinted.gap_m, plain.gap_m)) << hinted.gap_m - plain.gap_m;
  ASSERT_TRUE(same_bits(hinted.normal, plain.normal)) << norm(hinted.normal - plain.normal);
  ASSERT_TRUE(same_bits(hinted.point_a_m, plain.point_a_m));
  ASSERT_TRUE(same_bits(hinted.point_b_m, plain.point_b_m));
  ASSERT_EQ(hinted.feature_a, plain.feature_a);
  ASSERT_EQ(hinted.feature_b, plain.feature_b);
}

Feature any_feature(random::Stream& stream, const ConvexView& piece) {
  const auto kind = static_cast<FeatureKind>(stream.bits() % 3);
  const std::uint16_t count = kind == FeatureKind::vertex ? piece.vertex_count
                              : kind == FeatureKind::edge ? piece.edge_count
                                                          : piece.face_count;
  return {kind, static_cast<std::uint16_t>(stream.bits() % count)};
}

// A random piece, or a box of any size. A box may be a plate or a rod.
std::unique_ptr<Piece> near_piece(random::Stream& stream) {
  const double size_m = log_between(stream, 3e-3, 3);
  if (stream.bits() % 4 != 0) return random_piece(stream, size_m);
  auto piece = std::make_unique<Piece>();
  piece->kind = "box";
  const Vec3 sides(log_between(stream, 0.2, 5), log_between(stream, 0.2, 5),
                   log_between(stream, 0.02, 1));
  const auto solid = box(size_m * sides);
  CHECK(solid.ok());
  piece->polyhedron = solid.value();
  return piece;
}

// A direction towards a face, an edge or a vertex of the piece.
Vec3 towards_feature(random::Stream& stream, const ConvexView& piece) {
  const auto kind = stream.bits() % 3;
  const auto face_normal = [&](std::size_t face) { return piece.faces[face].normal; };
  if (kind == 1) {
    const Edge& edge = piece.edges[stream.bits() % piece.edge_count];
    const Vec3 sum = face_normal(edge.face[0]) + face_normal(edge.face[1]);
    if (norm(sum) > 1e-3) return math::normalized(sum);
  }
  if (kind == 2) {
    const Vec3& vertex = piece.vertices_m[stream.bits() % piece.vertex_count];
    if (norm(vertex) > 0) return math::normalized(vertex);
  }
  return face_normal(stream.bits() % piece.face_count);
}

// The rotation that maps x to y. It is orthonormal up to rounding.
Mat3 turn_onto(const Vec3& x, const Vec3& y) {
  const Vec3 axis = math::cross(x, y);
  const double sine = norm(axis);
  if (sine < 1e-9) return Mat3::Identity();
  return math::matrix_of(
      math::quaternion_of_rotation_vector(std::atan2(sine, math::dot(x, y)) / sine * axis));
}

Mat3 product_of(const Mat3& first, const Mat3& second) {
  Mat3 result;
  for (int j = 0; j < 3; ++j)
    result.col(j) = math::product(first, second.col(j));
  return result;
}

// Places B over a face of A, or anywhere. If B is over a face, a feature of B points at the face,
// up to a tilt of 1e-12 to 1 rad.
Placement near_placement(random::Stream& stream, const ConvexView& a, const ConvexView& b) {
  Placement at;
  at.a.rotation = random_rotation(stream);
  at.a.position_m = between(stream, 0, 3) * random_unit(stream);
  at.b.rotation = random_rotation(stream);
  Vec3 up = random_unit(stream);
  if (stream.bits() % 4 != 0) {
    up = math::product(at.a.rotation, a.faces[stream.bits() % a.face_count].normal);
    const Vec3 down = math::product(at.b.rotation, towards_feature(stream, b));
    const Vec3 tilt = log_between(stream, 1e-12, 1) * random_unit(stream);
    at.b.rotation = product_of(math::matrix_of(math::quaternion_of_rotation_vector(tilt)),
                               product_of(turn_onto(down, -up), at.b.rotation));
  }
  const double aside_m = between(stream, 0, 1) * std::min(a.r_outer_m, b.r_outer_m);
  const Vec3 any = random_unit(stream);
  at.b.position_m = at.a.position_m + 1.1 * (a.r_outer_m + b.r_outer_m) * up +
                    aside_m * (any - math::dot(any, up) * up);
  return at;
}

// Goal: closest_cold returns the same bits with any hint, even if the hint makes the search
// unnecessary (only_one()). Method: place pieces 3e-10 to 1e-5 m apart. Some pairs have nearly
// parallel faces and edges. Use three hints: the features that closest_warm found, the features
// that closest_cold found, and random features. With SLEIGHT_SOAK, the test runs 15 times as many
// cases.
TEST(ClosestCold, gives_the_same_bits_with_any_hint) {
  const auto cases =
      static_cast<int>(property::long_run() ? 3'000'000 : property::of_tier(40'000, 200'000));
  constexpr std::uint64_t k_pairs_max = 1'000'000;  // more than needed
  int quick = 0;
  int done = 0;
  std::array<int, 3> kinds{};  // edge-edge, face-vertex, vertex-face
  for (const std::uint64_t i : property::cases(k_pairs_max)) {
    if (done >= cases) break;
    random::Stream stream = numbers(403, i);
    SCOPED_TRACE("numbers(403, " + std::to_string(i) + ")");
    const auto piece_a = near_piece(stream);
    const auto piece_b = near_piece(stream);
    const ConvexView a = piece_a->view(), b = piece_b->view();
    for (int placement = 0; placement < 8; ++placement) {
      Placement at = near_placement(stream, a, b);
      at.b = at_gap(a, at.a, b, at.b, 1e-4);
      SeparationCache cache;
      // Move B closer and closer, or slightly to the side.
      double gap_m = 1e-5;
      for (int closer = 0; closer < 6; ++closer) {
        at.b = at_gap(a, at.a, b, at.b, gap_m);
        const Closest plain = closest_cold(a, at.a, b, at.b);
        closest_warm(a, at.a, b, at.b, cache);
        SeparationCache own = cache;
        own.a = plain.feature_a;
        own.b = plain.feature_b;
        SeparationCache wrong = cache;
        wrong.a = any_feature(stream, a);
        wrong.b = any_feature(stream, b);
        for (SeparationCache hint : {cache, own, wrong}) {
          hint.filled = true;
          const Closest hinted = closest_cold(a, at.a, b, at.b, hint);
          ASSERT_NO_FATAL_FAILURE(expect_same_bits(hinted, plain)) << plain.gap_m;
          if (hinted.search != Search::features) continue;
          ++quick;
          ++kinds[hinted.feature_a.kind == FeatureKind::edge     ? 0
                  : hinted.feature_a.kind == FeatureKind::vertex ? 2
                                                                 : 1];
        }
        ++done;
        gap_m = std::max(3e-10, gap_m * log_between(stream, 0.03, 1));
      }
    }
  }
  if (!property::all_cases()) return;
  std::printf(
      "seed 403: %d cases, %d quick answers: edge-edge %d, face-vertex %d, vertex-face %d\n", done,
      quick, kinds[0], kinds[1], kinds[2]);
  for (const int count : kinds)
    EXPECT_GT(count, cases / 100);
}

}  // namespace
}  // namespace sleight::physics
