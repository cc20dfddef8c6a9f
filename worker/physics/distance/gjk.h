// GJK and its simplex. The simplex is up to four points of B - A. These points support the
// simplex's closest point to the origin.
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

/// Stores the simplex's closest point to the origin in `closest`. Drops the points that do not
/// support it, and sets the weights. Returns false if the origin is inside a tetrahedron. REQUIRES:
/// 1 to 4 points. The points may be collinear or coplanar.
bool reduce(Simplex& simplex, Vec3& closest);

enum class GjkOutcome : std::uint8_t { separated, overlapping };

/// Runs GJK until no vertex is closer. Starts from `simplex`, which may be empty, and from
/// `closest` as the first direction. On return, `closest` is the vector from A to B, only as
/// accurate as GJK. If `climb` is set, finds the furthest vertices by climbing from the simplex's
/// vertices. Otherwise scans all vertices. REQUIRES: `closest` is not zero; if `climb` is set, the
/// simplex is not empty.
GjkOutcome descend(const PiecePair& pair, bool climb, Simplex& simplex, Vec3& closest);

}  // namespace sleight::physics
