// GJK's simplex: which part of up to four points of B - A is closest to the origin.
//
// Internal to worker/physics/distance; see closest_points.h. Thread safety: pure functions.
#pragma once

#include <array>
#include <cstdint>

#include "worker/physics/distance/feature_pairs.h"

namespace sleight::physics {

/// A vertex of B less a vertex of A, in A's frame.
struct SimplexPoint {
  Vec3 difference_m = Vec3::Zero();
  std::uint16_t a = 0;
  std::uint16_t b = 0;
};

struct Simplex {
  std::array<SimplexPoint, 4> points{};
  std::array<double, 4> weights{};  ///< of the closest point; they sum to 1
  int count = 0;
};

/// Drops the points that do not carry the point of the simplex closest to the origin, sets the
/// weights and returns that point in `closest`. False if the origin lies inside a tetrahedron.
/// REQUIRES: 1 to 4 points. Points in line or in a plane are fine.
bool reduce(Simplex& simplex, Vec3& closest);

enum class GjkOutcome : std::uint8_t { separated, overlapping };

/// Descends from a simplex (or none) and a first direction until no vertex is closer; `closest` is
/// then the vector from A to B up to the accuracy that GJK reaches by itself. With `climb` the
/// furthest vertices are found from those of the simplex, else by a scan.
/// REQUIRES: closest is not zero; with climb, the simplex is not empty.
GjkOutcome descend(const PiecePair& pair, bool climb, Simplex& simplex, Vec3& closest);

}  // namespace sleight::physics
