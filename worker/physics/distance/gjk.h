// GJK's simplex: up to four points of B - A that support its closest point to the origin.
//
// Internal to worker/physics/distance; see closest_points.h. Thread safety: pure functions.
#pragma once

#include <array>
#include <cstdint>

#include "worker/physics/distance/feature_pairs.h"

namespace sleight::physics {

/// A vertex of B minus a vertex of A, in A's frame.
struct SimplexPoint {
  Vec3 difference_m = Vec3::Zero();
  std::uint16_t a = 0;
  std::uint16_t b = 0;
};

struct Simplex {
  std::array<SimplexPoint, 4> points{};
  std::array<double, 4> weights{};  ///< of the closest point; the sum is 1
  int count = 0;
};

/// Drops points that do not support the simplex's closest point to the origin, sets the weights and
/// returns the closest point in `closest`. Returns false if the origin is inside a tetrahedron.
/// REQUIRES: 1 to 4 points. The points may be collinear or coplanar.
bool reduce(Simplex& simplex, Vec3& closest);

enum class GjkOutcome : std::uint8_t { separated, overlapping };

/// Runs GJK from a simplex, which may be empty, and a first direction until no vertex is closer.
/// Then `closest` is the vector from A to B, with the accuracy of GJK alone. `climb`: whether to
/// find the furthest vertices by climbing from the simplex's vertices, instead of scanning all
/// vertices. REQUIRES: `closest` is not zero; if `climb` is set, the simplex is not empty.
GjkOutcome descend(const PiecePair& pair, bool climb, Simplex& simplex, Vec3& closest);

}  // namespace sleight::physics
