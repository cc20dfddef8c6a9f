#include "worker/physics/simulator/convex_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sleight::physics {
namespace {

constexpr double k_forever_s = std::numeric_limits<double>::infinity();
/// Corners of the envelope that one look goes along; it may stop at any of them.
constexpr int k_corners_max = 12;
/// A skip is shortened by this share for the rounding of its own computation.
constexpr double k_skip_margin = 0x1p-20;

/// A vertex along the axis: place + rate h.
struct Line {
  double place_m = 0;
  double rate_mps = 0;
};

/// The lines of a piece's vertices, of which the lowest counts.
class Envelope {
 public:
  /// `axis`: which way is up. Places are from the body's centre.
  Envelope(const MovingPiece& piece, const Vec3& axis)
      : view_(*piece.view),
        place_(transposed_product(piece.pose.rotation, axis)),
        rate_(transposed_product(piece.pose.rotation,
                                 math::cross(axis, piece.angular_velocity_radps))) {}

  /// The line that is lowest at first, and of those that are equal there the one that falls most.
  Line lowest() const {
    Line best = line(0);
    for (std::size_t i = 1; i < view_.vertex_count; ++i) {
      const Line other = line(i);
      if (other.place_m < best.place_m ||
          (other.place_m == best.place_m && other.rate_mps < best.rate_mps)) {
        best = other;
      }
    }
    return best;
  }

  /// The line that next passes below `current`, and when.
  double next_after(const Line& current, Line& next) const {
    double first_s = k_forever_s;
    for (std::size_t i = 0; i < view_.vertex_count; ++i) {
      const Line other = line(i);
      const double faster = current.rate_mps - other.rate_mps;
      if (!(faster > 0)) continue;
      const double above = other.place_m - current.place_m;
      // Compared without a division: above / faster < first.
      if (above < first_s * faster) {
        first_s = above / faster;
        next = other;
      }
    }
    return first_s;
  }

 private:
  Line line(std::size_t i) const {
    const double x = view_.xs_m[i];
    const double y = view_.ys_m[i];
    const double z = view_.zs_m[i];
    return {(place_.x() * x + place_.y() * y) + place_.z() * z,
            (rate_.x() * x + rate_.y() * y) + rate_.z() * z};
  }

  const ConvexView& view_;
  Vec3 place_;
  Vec3 rate_;
};

/// First h >= from at which place + rate h - fall h^2 / 2 <= k_touch and rate - fall h <
/// -k_approach.
double first_collision_s(const Line& line, double fall, double from_s) {
  // When it falls fast enough.
  double h = from_s;
  if (line.rate_mps - fall * h >= -k_approach_mps) {
    if (fall <= 0) return k_forever_s;
    h = std::max(from_s, (line.rate_mps + k_approach_mps) / fall);
  }
  const double excess_m = line.place_m - k_touch_m;
  if (excess_m + h * (line.rate_mps - 0.5 * fall * h) <= 0) return h;
  // When it comes down to the touch: the later root.
  if (fall <= 0) return excess_m / -line.rate_mps;
  const double root = std::sqrt(std::max(0.0, line.rate_mps * line.rate_mps + 2 * fall * excess_m));
  const double down_s =
      line.rate_mps < 0 ? 2 * excess_m / (root - line.rate_mps) : (root + line.rate_mps) / fall;
  return std::max(h, down_s);
}

/// Walks along the envelope of two sets of lines, the second of which may be fixed.
double failing_along(const Line& base, double fall, const Envelope* first, const Envelope& second) {
  Line a = first != nullptr ? first->lowest() : Line{};
  Line b = second.lowest();
  double from_s = 0;
  for (int corner = 0; corner < k_corners_max; ++corner) {
    const Line sum{(base.place_m + a.place_m) + b.place_m,
                   (base.rate_mps + a.rate_mps) + b.rate_mps};
    const double collision_s = first_collision_s(sum, fall, from_s);
    Line next_a;
    Line next_b;
    const double corner_a_s = first != nullptr ? first->next_after(a, next_a) : k_forever_s;
    const double corner_b_s = second.next_after(b, next_b);
    const double corner_s = std::max(from_s, std::min(corner_a_s, corner_b_s));
    if (collision_s <= corner_s) return collision_s;
    from_s = corner_s;
    if (corner_a_s <= corner_b_s) {
      a = next_a;
    } else {
      b = next_b;
    }
  }
  return from_s;
}

Examined later(Tick tick, double span_s) {
  if (!(span_s < seconds(k_tick_max.value))) return {.collides = false, .next = k_never};
  const TickCount span = ticks_before(span_s * (1 - k_skip_margin));
  return {.collides = false, .next = tick + std::max<TickCount>(1, span)};
}

Vec3 velocity_of(const MovingPiece& piece, const Vec3& point_m) {
  return piece.velocity_mps +
         math::cross(piece.angular_velocity_radps, point_m - piece.pose.position_m);
}

bool collides(const PieceContact& contact) {
  return contact.gap_m <= k_touch_m && contact.rate_mps < -k_approach_mps;
}

/// Least h >= 0 at which place + rate h + curvature h^2 / 2 <= 0.
double first_zero_s(double place, double rate, double curvature) {
  if (place <= 0) return 0;
  const double discriminant = rate * rate - 2 * curvature * place;
  if (discriminant < 0) return k_forever_s;
  const double root = std::sqrt(discriminant);
  if (curvature < 0 && rate >= 0) return -(rate + root) / curvature;
  return rate < 0 ? 2 * place / (root - rate) : k_forever_s;
}

/// How far below its centre a piece may come along the axis of its envelope, as a negative number.
double nearest_m(const MovingPiece& piece, const Envelope& envelope) {
  return std::isfinite(piece.reach_m) ? -piece.reach_m : envelope.lowest().place_m;
}

}  // namespace

PieceContact contact_of(const MovingPiece& a, const MovingPiece& b) {
  const Closest closest = closest_cold(*a.view, a.pose, *b.view, b.pose);
  const Vec3 on_a_m = closest.point_a_m + a.radius_m * closest.normal;
  const Vec3 on_b_m = closest.point_b_m - b.radius_m * closest.normal;
  return {.gap_m = closest.gap_m - (a.radius_m + b.radius_m),
          .rate_mps = math::dot(closest.normal, velocity_of(b, on_b_m) - velocity_of(a, on_a_m)),
          .normal = closest.normal,
          .point_m = 0.5 * (on_a_m + on_b_m)};
}

PieceContact contact_of(const HalfSpace& solid_below, const MovingPiece& b) {
  const Closest closest =
      closest_to_plane(solid_below.normal, solid_below.offset_m, *b.view, b.pose);
  const Vec3 on_b_m = closest.point_b_m - b.radius_m * closest.normal;
  const double gap_m = closest.gap_m - b.radius_m;
  return {.gap_m = gap_m,
          .rate_mps = math::dot(closest.normal, velocity_of(b, on_b_m)),
          .normal = closest.normal,
          .point_m = on_b_m - (0.5 * gap_m) * closest.normal};
}

Examined examine_pieces(const MovingPiece& a, const MovingPiece& b, Tick tick,
                        SeparationCache& cache) {
  // As long as their spheres are apart, nothing else need be asked.
  const Vec3 between_m = b.pose.position_m - a.pose.position_m;
  const double reach_m = a.reach_m + b.reach_m + k_touch_m;
  const double distance_m = math::norm(between_m);
  if (distance_m > reach_m) {
    const Vec3 pull_mps2 = b.acceleration_mps2 - a.acceleration_mps2;
    const double rate_mps = math::dot(between_m, b.velocity_mps - a.velocity_mps) / distance_m;
    return later(tick, first_zero_s(distance_m - reach_m, rate_mps, -math::norm(pull_mps2)));
  }

  // How far they are apart; near the touch, from scratch.
  const Closest closest = closest_warm(*a.view, a.pose, *b.view, b.pose, cache);
  Vec3 axis = closest.normal;
  if (closest.gap_m - (a.radius_m + b.radius_m) <= 2 * k_touch_m) {
    const PieceContact contact = contact_of(a, b);
    if (collides(contact)) return {.collides = true, .next = tick};
    axis = contact.normal;
  }

  // How long they can't collide along the line of the closest points.
  const Line base{math::dot(axis, between_m) - (a.radius_m + b.radius_m),
                  math::dot(axis, b.velocity_mps - a.velocity_mps)};
  const double pull = math::dot(axis, b.acceleration_mps2 - a.acceleration_mps2);
  const double fall =
      std::max(0.0, (a.turning_acceleration_mps2 + b.turning_acceleration_mps2) - pull);
  const Envelope of_a(a, -axis);
  const Envelope of_b(b, axis);
  double span_s = failing_along(base, fall, &of_a, of_b);

  // However they turn, they stay inside of their spheres; what doesn't turn stays behind its plane.
  const double apart_m = base.place_m + (nearest_m(a, of_a) + nearest_m(b, of_b)) - k_touch_m;
  if (apart_m > 0) span_s = std::max(span_s, first_zero_s(apart_m, base.rate_mps, pull));
  return later(tick, span_s);
}

Examined examine_plane(const HalfSpace& solid_below, const MovingPiece& b, Tick tick) {
  const Vec3& axis = solid_below.normal;
  const Line base{math::dot(axis, b.pose.position_m) - solid_below.offset_m - b.radius_m,
                  math::dot(axis, b.velocity_mps)};
  const Envelope of_b(b, axis);
  if (base.place_m + of_b.lowest().place_m <= 2 * k_touch_m &&
      collides(contact_of(solid_below, b))) {
    return {.collides = true, .next = tick};
  }
  const double pull = math::dot(axis, b.acceleration_mps2);
  const double fall = std::max(0.0, b.turning_acceleration_mps2 - pull);
  double span_s = failing_along(base, fall, nullptr, of_b);
  const double sphere_m = base.place_m - b.reach_m - k_touch_m;
  if (sphere_m > 0) span_s = std::max(span_s, first_zero_s(sphere_m, base.rate_mps, pull));
  return later(tick, span_s);
}

TickCount touch_of_free_spheres(const Vec3& between_m, const Vec3& relative_mps, double radii_m) {
  const double distance_m = math::norm(between_m);
  const double excess_m = distance_m - (radii_m + k_touch_m);
  if (excess_m <= 0) return 0;
  const double towards = math::dot(between_m, relative_mps);
  const double speed2 = math::dot(relative_mps, relative_mps);
  const double excess_m2 = excess_m * (distance_m + (radii_m + k_touch_m));
  const double discriminant = towards * towards - speed2 * excess_m2;
  if (towards >= 0 || discriminant < 0) return k_tick_max.value;
  return ticks_before(excess_m2 / (std::sqrt(discriminant) - towards) * (1 - k_skip_margin));
}

}  // namespace sleight::physics
