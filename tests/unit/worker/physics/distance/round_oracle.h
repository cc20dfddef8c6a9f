// Finds the gap of two convex bodies by a slow search over all axes. Uses only the bodies' reach in
// each direction.
//
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "common/math/vector.h"
#include "worker/physics/distance/placed_pose.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/round_piece.h"

namespace sleight::physics::testing {

/// Reach of a piece along a unit direction in the world's frame. Shares no code with the library.
inline double plain_reach_m(const ConvexView& piece, const PlacedPose& pose, const Vec3& u) {
  double most_m = -1e300;
  const auto offer = [&](const Vec3& point_m, double more_m) {
    most_m = std::max(most_m, math::dot(to_world(pose, point_m), u) + more_m);
  };
  if (piece.round == nullptr) {
    for (std::size_t i = 0; i < piece.vertex_count; ++i)
      offer(piece.vertices_m[i], 0);
    return most_m;
  }
  const Vec3 axis = math::product(pose.rotation, piece.round->axis());
  for (const RoundFeature& feature : piece.round->features())
    offer(feature.centre_m, feature.circle_m * math::norm(math::cross(axis, u)) + feature.radius_m);
  return most_m;
}

/// Greatest separation along any axis. Tries some thousand axes, then improves the best axis with
/// shrinking steps. `start` is an extra axis to try.
inline double oracle_gap_m(const ConvexView& a, const PlacedPose& pose_a, const ConvexView& b,
                           const PlacedPose& pose_b, const Vec3& start) {
  const auto separation_m = [&](const Vec3& n) {
    return -plain_reach_m(a, pose_a, n) - plain_reach_m(b, pose_b, -n);
  };
  struct Try {
    double gap_m;
    Vec3 axis;
  };
  std::vector<Try> tries;
  constexpr int k_axes = 600;
  for (int i = 0; i < k_axes; ++i) {
    const double z = 1 - (2 * i + 1.0) / k_axes;
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    const Vec3 axis(r * std::cos(angle), r * std::sin(angle), z);
    tries.push_back({separation_m(axis), axis});
  }
  tries.push_back({separation_m(start), start});
  std::partial_sort(tries.begin(), tries.begin() + 4, tries.end(),
                    [](const Try& p, const Try& q) { return p.gap_m > q.gap_m; });
  double best_m = -1e300;
  for (std::size_t k = 0; k < 4; ++k) {
    Try now = tries[k];
    for (double step = 0.1; step > 1e-9;) {
      bool better = false;
      const Vec3 first = math::normalized(math::cross(
          now.axis, std::fabs(now.axis.x()) < 0.9 ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY())));
      const Vec3 second = math::cross(now.axis, first);
      for (int i = 0; i < 8; ++i) {
        const double angle = i * std::numbers::pi / 4;
        const Vec3 other = math::normalized(
            now.axis + step * (std::cos(angle) * first + std::sin(angle) * second));
        const double gap_m = separation_m(other);
        if (gap_m <= now.gap_m) continue;
        now = {gap_m, other};
        better = true;
        break;
      }
      if (!better) step *= 0.5;
    }
    best_m = std::max(best_m, now.gap_m);
  }
  return best_m;
}

}  // namespace sleight::physics::testing
