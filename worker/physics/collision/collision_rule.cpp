#include "worker/physics/collision/collision_rule.h"

#include "worker/physics/distance/round_distance.h"

namespace sleight::physics {

PieceContact contact_from(const Closest& closest, const MovingPiece& a, const MovingPiece& b) {
  const Vec3 on_a_m = closest.point_a_m + a.radius_m * closest.normal;
  const Vec3 on_b_m = closest.point_b_m - b.radius_m * closest.normal;
  return {.gap_m = closest.gap_m - (a.radius_m + b.radius_m),
          .rate_mps = math::dot(closest.normal, velocity_of(b, on_b_m) - velocity_of(a, on_a_m)),
          .normal = closest.normal,
          .point_m = 0.5 * (on_a_m + on_b_m)};
}

PieceContact contact_of(const MovingPiece& a, const MovingPiece& b) {
  return contact_from(is_round(a) || is_round(b) ? closest_round(*a.view, a.pose, *b.view, b.pose)
                                                 : closest_cold(*a.view, a.pose, *b.view, b.pose),
                      a, b);
}

PieceContact contact_of(const HalfSpace& solid_below, const MovingPiece& b) {
  const Closest closest =
      is_round(b)
          ? closest_round_to_plane(solid_below.normal, solid_below.offset_m, *b.view, b.pose)
          : closest_to_plane(solid_below.normal, solid_below.offset_m, *b.view, b.pose);
  const Vec3 on_b_m = closest.point_b_m - b.radius_m * closest.normal;
  const double gap_m = closest.gap_m - b.radius_m;
  return {.gap_m = gap_m,
          .rate_mps = math::dot(closest.normal, velocity_of(b, on_b_m)),
          .normal = closest.normal,
          .point_m = on_b_m - (0.5 * gap_m) * closest.normal};
}

}  // namespace sleight::physics
