#include "worker/physics/collision/convex_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "worker/physics/collision/envelope.h"
#include "worker/physics/collision/first_collision.h"
#include "worker/physics/collision/piece_motion.h"
#include "worker/physics/collision/round_search.h"

namespace sleight::physics {
namespace {

using envelope::Envelope;
using envelope::Line;

/// The search margins below affect only the speed, and how late a collision may be found
/// (piece_motion.h). Maximum number of an envelope's corners that a look visits. A look may stop at
/// any corner.
constexpr int k_corners_max = 12;
/// A gap may be computed from earlier looks' results or from scratch. The two values differ by less
/// than this, the rounding at coordinates of 100 m.
constexpr double k_warm_error_m = 1e-12;

/// Maximum time span computed for a touching pair.
constexpr double k_touching_s = 1;

/// Adds the base and both pieces' lines. A plane's line is k_no_line.
Line sum_of(const Line& base, const Line& a, const Line& b) {
  return {(base.place_m + a.place_m) + b.place_m, (base.rate_mps + a.rate_mps) + b.rate_mps};
}
constexpr Line k_no_line{0, 0};

/// Returns the earliest time at which the sum of two envelopes may reach the touch distance. For a
/// plane, `first` is null.
double comes_down_s(const Line& base, double fall, Envelope* first, Envelope& second,
                    double from_s) {
  const auto touch_s = [&](const Line& a, const Line& b, double since_s) {
    const Line line = sum_of(base, a, b);
    return first_touch_s(line.place_m, line.rate_mps, fall, since_s);
  };
  // The two lines that are lowest now give an upper bound of the result, `until_s`. Only lines that
  // become lower than these before `until_s` can lower the result. Usually no line does.
  const double until_s =
      touch_s(first != nullptr ? first->first() : k_no_line, second.first(), from_s);
  const bool first_changes = first != nullptr && first->keep_until(until_s);
  const bool second_changes = second.keep_until(until_s);
  if (!first_changes && !second_changes) return until_s;
  Line a = first != nullptr ? first->first() : k_no_line;
  Line b = second.first();
  for (int corner = 0; corner < k_corners_max; ++corner) {
    const double down_s = touch_s(a, b, from_s);
    Line next_a = a;
    Line next_b = b;
    const double corner_a_s = first_changes ? first->next_after(a, next_a) : k_forever_s;
    const double corner_b_s = second_changes ? second.next_after(b, next_b) : k_forever_s;
    const double corner_s = std::max(from_s, std::min(corner_a_s, corner_b_s));
    if (down_s <= corner_s) return down_s;
    from_s = corner_s;
    if (corner_a_s <= corner_b_s) {
      a = next_a;
    } else {
      b = next_b;
    }
  }
  return from_s;
}

/// Returns 2 h plus a tick, where h is the time at which line(h) - fall h^2 / 2 reaches the touch
/// distance from below. Returns k_forever_s if there is no such time.
double comes_out_s(const Line& line, double fall) {
  const double deep_m = k_touch_m - line.place_m;
  const double discriminant = line.rate_mps * line.rate_mps - 2 * fall * deep_m;
  if (!(line.rate_mps > 0 && discriminant > 0)) return k_forever_s;
  const double out_s = 2 * std::max(0.0, deep_m) / (line.rate_mps + std::sqrt(discriminant));
  return 2 * out_s + k_seconds_per_tick;
}

/// Returns the earliest time at which a vertex may become the lowest of its piece. After time h,
/// each line's error is at most bend h^2 / 2 plus rounding, not counting terms that both lines
/// share.
double takes_over_s(const Line& line, const Line& lowest, double bend, double rounding_m) {
  const double above_m = line.place_m - lowest.place_m - rounding_m;
  const double faster_mps = lowest.rate_mps - line.rate_mps;
  if (above_m <= 0) return 0;
  if (bend <= 0) return faster_mps > 0 ? above_m / faster_mps : k_forever_s;
  const double root = std::sqrt(faster_mps * faster_mps + 4 * bend * above_m);
  return faster_mps > 0 ? 2 * above_m / (root + faster_mps) : (root - faster_mps) / (2 * bend);
}

/// Returns a time, at most `until_s`, for which two touching pieces can't collide. The axis turns
/// with the touching features. While the same vertices are lowest, the gap falls as fast as these
/// vertices do. Once other vertices are the lowest, other features may touch, along another normal.
/// So the returned time isn't longer, unless all these vertices move apart.
double touching_along(const Line& base, double fall, double bend, double rounding_m,
                      Envelope* first, Envelope& second, double until_s) {
  const Line lowest_a = first != nullptr ? first->first() : k_no_line;
  const Line lowest_b = second.first();
  const Line lowest = sum_of(base, lowest_a, lowest_b);
  until_s = std::min(until_s, first_collision_s(lowest.place_m, lowest.rate_mps, fall, 0));
  const double margin_m = bend * until_s * until_s + rounding_m;
  const std::span<const Line> of_a =
      first != nullptr ? first->keep_near_until(until_s, margin_m) : std::span(&k_no_line, 1);
  const std::span<const Line> of_b = second.keep_near_until(until_s, margin_m);
  // Vertices with similar motion may stay equally low for long, so use the vertex that falls
  // fastest.
  constexpr double k_alike_mps = 0.25 * k_approach_mps;
  double falls_mps = base.rate_mps;
  double takes_over = k_forever_s;
  double alike_from_s = k_forever_s;
  double alike_mps = lowest.rate_mps;
  const auto add = [&](std::span<const Line> lines, const Line& own) {
    double least_mps = own.rate_mps;
    double least_alike_mps = own.rate_mps;
    for (const Line& line : lines) {
      least_mps = std::min(least_mps, line.rate_mps);
      const double from_s = takes_over_s(line, own, bend, rounding_m);
      if (std::fabs(line.rate_mps - own.rate_mps) > k_alike_mps) {
        takes_over = std::min(takes_over, from_s);
      } else if (line.rate_mps < own.rate_mps && from_s < until_s) {
        least_alike_mps = std::min(least_alike_mps, line.rate_mps);
        alike_from_s = std::min(alike_from_s, from_s);
      }
    }
    falls_mps += least_mps;
    alike_mps -= own.rate_mps - least_alike_mps;
  };
  add(of_a, lowest_a);
  add(of_b, lowest_b);
  if (alike_from_s < until_s)
    until_s = std::min(until_s, first_collision_s(lowest.place_m, alike_mps, fall, alike_from_s));
  if (!(takes_over < until_s)) return until_s;
  // Compute the earliest time at which any vertex may fall.
  const double left_mps = falls_mps + 0.5 * k_approach_mps;
  const double falls_s = left_mps <= 0 ? 0 : fall > 0 ? left_mps / fall : k_forever_s;
  return std::min(until_s, std::max(takes_over, falls_s));
}

/// Returns the piece's maximum reach from its centre towards the other piece, with a minus sign.
double nearest_m(const MovingPiece& piece, const Envelope& envelope) {
  return std::isfinite(piece.reach_m) ? -piece.reach_m : envelope.lowest_m();
}

/// An axis's angular velocity. Turning the axis makes the separation fall faster: `fall_mps2` is
/// this additional acceleration.
struct AxisTurn {
  Vec3 angular_velocity_radps = Vec3::Zero();
  double fall_mps2 = 0;
  double valid_s = k_forever_s;  ///< time for which fall_mps2 holds
};

Vec3 direction_of(const MovingPiece& piece, Feature edge) {
  const Edge& of = piece.view->edges[edge.index];
  return math::product(piece.pose.rotation,
                       piece.view->vertices_m[of.vertex[1]] - piece.view->vertices_m[of.vertex[0]]);
}

/// Returns the angular velocity of the line from a vertex to another vertex or an edge. The line
/// turns with the edge. If either piece has a radius, the line also turns with the closest points'
/// relative motion.
Vec3 turn_of_line(const MovingPiece& a, const MovingPiece& b, const Closest& closest) {
  const Vec3& n = closest.normal;
  Vec3 normal_rate = Vec3::Zero();
  if (a.radius_m + b.radius_m > 0 && closest.gap_m > 0) {
    const Vec3 past_mps = velocity_of(b, closest.point_b_m) - velocity_of(a, closest.point_a_m);
    normal_rate = (past_mps - math::dot(n, past_mps) * n) / closest.gap_m;
  }
  const bool edge_of_a = closest.feature_a.kind == FeatureKind::edge;
  if (edge_of_a || closest.feature_b.kind == FeatureKind::edge) {
    const MovingPiece& piece = edge_of_a ? a : b;
    const Vec3 edge =
        math::normalized(direction_of(piece, edge_of_a ? closest.feature_a : closest.feature_b));
    const double along = -math::dot(n, math::cross(piece.angular_velocity_radps, edge));
    normal_rate += (along - math::dot(normal_rate, edge)) * edge;
  }
  return math::cross(n, normal_rate);
}

/// Returns the angular velocity of the closest features' normal. The normal turns with a face,
/// stays perpendicular to two edges, or follows the line between other features.
Vec3 turn_of_axis(const MovingPiece& a, const MovingPiece& b, const Closest& closest) {
  const bool with_a = closest.feature_a.kind == FeatureKind::face;
  const bool with_b = closest.feature_b.kind == FeatureKind::face;
  const Vec3& spin_a = a.angular_velocity_radps;
  const Vec3& spin_b = b.angular_velocity_radps;
  // Choose the face that turns more slowly, so that far vertices move less relative to the axis.
  if (with_a && with_b)
    return math::dot(spin_a, spin_a) <= math::dot(spin_b, spin_b) ? spin_a : spin_b;
  if (with_b) return spin_b;
  if (with_a) return spin_a;
  if (closest.feature_a.kind != FeatureKind::edge || closest.feature_b.kind != FeatureKind::edge)
    return turn_of_line(a, b, closest);
  // Solve n'.n = 0 and n'.e = -n.(w x e) for both edges e. In the plane of e_a and e_b, use the
  // basis dual to them.
  const Vec3& n = closest.normal;
  const Vec3 edge_a = math::normalized(direction_of(a, closest.feature_a));
  const Vec3 edge_b = math::normalized(direction_of(b, closest.feature_b));
  const double cosine = math::dot(edge_a, edge_b);
  const double sine2 = 1 - cosine * cosine;
  if (sine2 < 1e-4) return Vec3::Zero();
  const double of_a = -math::dot(n, math::cross(a.angular_velocity_radps, edge_a));
  const double of_b = -math::dot(n, math::cross(b.angular_velocity_radps, edge_b));
  const Vec3 turn = ((of_a - cosine * of_b) * edge_a + (of_b - cosine * of_a) * edge_b) / sine2;
  return math::cross(n, turn);
}

/// Returns an upper bound on the distance from a point to the piece's furthest vertex.
double furthest_from(const MovingPiece& piece, const Vec3& point_m) {
  if (std::isfinite(piece.reach_m)) {
    return piece.reach_m + math::norm(piece.pose.position_m - point_m);
  }
  double most_m2 = 0;
  for (std::size_t i = 0; i < piece.view->vertex_count; ++i) {
    const Vec3 from = to_world(piece.pose, piece.view->vertices_m[i]) - point_m;
    most_m2 = std::max(most_m2, math::dot(from, from));
  }
  return std::sqrt(most_m2);
}

/// Bounds how fast the gap's rate falls if the axis n turns about a point O with angular velocity
/// W. In a moving frame, the second derivative of n.x is n.(x'' - 2 W x x' + W x (W x (x - O))).
AxisTurn turning_axis(const MovingPiece& a, const MovingPiece& b, const Vec3& point_m,
                      const Vec3& angular_velocity_radps) {
  // If A is fixed, the frame has A's velocity; otherwise, it has the mean of both velocities.
  const bool a_fixed = !std::isfinite(a.reach_m);
  const Vec3 frame_mps = a_fixed ? a.velocity_mps : Vec3(0.5 * (a.velocity_mps + b.velocity_mps));
  const double far_a_m = furthest_from(a, point_m);
  const double far_b_m = furthest_from(b, point_m);
  const auto speed = [&](const MovingPiece& piece) {
    const double turning = piece.reach_m > 0 && std::isfinite(piece.reach_m)
                               ? std::sqrt(piece.turning_acceleration_mps2 * piece.reach_m)
                               : 0;
    return math::norm(piece.velocity_mps - frame_mps) + turning;
  };
  const double pull_mps2 = math::norm(b.acceleration_mps2 - a.acceleration_mps2);
  double speed_a_mps = speed(a);
  double speed_b_mps = speed(b);
  // The bound holds while both pieces move by at most a quarter of the smaller of the two
  // distances.
  const double room_m = 0.25 * std::min(far_a_m, far_b_m);
  const double fastest_mps = std::max(speed_a_mps, speed_b_mps) + std::sqrt(pull_mps2 * room_m);
  AxisTurn turn{.angular_velocity_radps = angular_velocity_radps};
  turn.valid_s = fastest_mps > 0 ? 0.5 * room_m / fastest_mps : k_forever_s;
  const double gained_mps = fastest_mps > 0 ? pull_mps2 * turn.valid_s : 0;
  const double w = math::norm(angular_velocity_radps);
  turn.fall_mps2 =
      2 * w * (speed_a_mps + speed_b_mps + gained_mps) + w * w * (far_a_m + far_b_m + 2 * room_m);
  return turn;
}

/// The envelopes of both pieces along an axis from A to B.
struct Shadows {
  Vec3 axis;
  Envelope of_a;
  Envelope of_b;

  Shadows(const MovingPiece& a, const MovingPiece& b, const Vec3& along)
      : axis(along), of_a(a, -along), of_b(b, along) {}
  double gap_m(const MovingPiece& a, const MovingPiece& b) const {
    return math::dot(axis, b.pose.position_m - a.pose.position_m) - (a.radius_m + b.radius_m) +
           (of_a.lowest_m() + of_b.lowest_m());
  }
};

/// Two pieces' separation along an axis, without the vertices' places, and bounds on how fast it
/// falls.
struct Separation {
  Line base;
  double fall_mps2;
  double bend_mps2;  ///< the part of fall_mps2 in which vertices differ
  double pull_mps2;  ///< relative acceleration of the centres
};
/// Computes the separation, and sets the angular velocity of the shadows' axis.
Separation separation_along(const MovingPiece& a, const MovingPiece& b, Shadows& shadows,
                            double touch_m, const AxisTurn& turn) {
  const Vec3& axis = shadows.axis;
  const Vec3 between_m = b.pose.position_m - a.pose.position_m;
  const Vec3 relative_mps = b.velocity_mps - a.velocity_mps;
  const Vec3 pull_mps2 = b.acceleration_mps2 - a.acceleration_mps2;
  const double pull = math::dot(axis, pull_mps2);
  // As the axis turns, its angle to the acceleration changes. In the worst case they are opposite.
  double towards = pull;
  if (!is_zero(turn.angular_velocity_radps)) {
    const double turns = math::norm(turn.angular_velocity_radps) * turn.valid_s;
    const double all = math::norm(pull_mps2);
    towards = std::max(-all, pull - turns * all);
  }
  const double bend = (a.turning_acceleration_mps2 + b.turning_acceleration_mps2) + turn.fall_mps2;
  shadows.of_a.turn(turn.angular_velocity_radps);
  shadows.of_b.turn(turn.angular_velocity_radps);
  return {
      .base = {math::dot(axis, between_m) - (a.radius_m + b.radius_m) + (k_touch_m - touch_m) -
                   rounding_m(a, b),
               math::dot(axis, relative_mps - math::cross(turn.angular_velocity_radps, between_m))},
      .fall_mps2 = std::max(0.0, bend - towards),
      .bend_mps2 = bend,
      .pull_mps2 = pull};
}

/// Returns a time for which two separate pieces can't touch, from their separation along an axis.
double open_for_s(const MovingPiece& a, const MovingPiece& b, Shadows& shadows, double touch_m,
                  const AxisTurn& turn) {
  const Separation separation = separation_along(a, b, shadows, touch_m, turn);
  const Line& base = separation.base;
  const double span_s = std::min(
      turn.valid_s, comes_down_s(base, separation.fall_mps2, &shadows.of_a, shadows.of_b, 0));
  if (!is_zero(turn.angular_velocity_radps)) return span_s;
  // A turning piece stays inside its bounding sphere. A fixed piece stays behind its plane.
  const double apart_m =
      base.place_m + (nearest_m(a, shadows.of_a) + nearest_m(b, shadows.of_b)) - k_touch_m;
  return apart_m > 0 ? std::max(span_s, first_zero_s(apart_m, base.rate_mps, separation.pull_mps2))
                     : span_s;
}

/// Returns a time for which two touching pieces can't collide. Along a fixed axis, the separation
/// falls at another rate than the gap. So while the pieces touch, the axis turns with their
/// features. If the pieces have separated along a fixed axis, they must approach along it before
/// they can collide.
double touching_for_s(const MovingPiece& a, const MovingPiece& b, Shadows& shadows, double touch_m,
                      const AxisTurn& turn) {
  const double vertices_m = k_rounding_ulps * (a.view->r_outer_m + b.view->r_outer_m);
  const Separation fixed = separation_along(a, b, shadows, touch_m, {});
  const double out_s =
      comes_out_s(sum_of(fixed.base, shadows.of_a.first(), shadows.of_b.first()), fixed.fall_mps2);
  const Separation turning = separation_along(a, b, shadows, touch_m, turn);
  const double until_s = std::min({k_touching_s, turn.valid_s, out_s});
  const double span_s = touching_along(turning.base, turning.fall_mps2, turning.bend_mps2,
                                       vertices_m, &shadows.of_a, shadows.of_b, until_s);
  if (span_s < out_s) return span_s;
  shadows.of_a.turn(Vec3::Zero());
  shadows.of_b.turn(Vec3::Zero());
  return comes_down_s(fixed.base, fixed.fall_mps2, &shadows.of_a, shadows.of_b, out_s);
}

/// Returns the direction from A's centre to B's. If a piece is fixed, uses the normal of its face
/// above which the other centre is highest (reversed if B is fixed).
Vec3 guessed_axis(const MovingPiece& a, const MovingPiece& b) {
  const auto of_faces = [](const MovingPiece& fixed, const MovingPiece& other) -> Vec3 {
    const Vec3 centre_m =
        transposed_product(fixed.pose.rotation, other.pose.position_m - fixed.pose.position_m);
    double most_m = -k_forever_s;
    std::size_t best = 0;
    for (std::size_t i = 0; i < fixed.view->face_count; ++i) {
      const Face& face = fixed.view->faces[i];
      const double above_m = math::dot(face.normal, centre_m) - face.offset_m;
      if (above_m > most_m) {
        most_m = above_m;
        best = i;
      }
    }
    return math::product(fixed.pose.rotation, fixed.view->faces[best].normal);
  };
  if (!std::isfinite(a.reach_m) && a.view->face_count > 0) return of_faces(a, b);
  if (!std::isfinite(b.reach_m) && b.view->face_count > 0) return -of_faces(b, a);
  const Vec3 between_m = b.pose.position_m - a.pose.position_m;
  const double distance_m = math::norm(between_m);
  return distance_m > 0 ? Vec3(between_m / distance_m) : Vec3(Vec3::UnitX());
}

}  // namespace

bool spheres_apart(const MovingPoint& a, const MovingPoint& b, double radii_m, double near_m,
                   Tick tick, Examined& examined) {
  const Vec3 between_m = b.position_m - a.position_m;
  const double distance_m = math::norm(between_m);
  const double excess_m = distance_m - (radii_m + k_touch_m);
  if (!(excess_m > k_well_apart * near_m)) return false;
  const Vec3 pull_mps2 = b.acceleration_mps2 - a.acceleration_mps2;
  const double rate_mps = math::dot(between_m, b.velocity_mps - a.velocity_mps) / distance_m;
  examined = look_after(tick, first_zero_s(excess_m, rate_mps, -math::norm(pull_mps2)));
  examined.gap_m = excess_m;
  return true;
}

bool sphere_above(const HalfSpace& solid_below, const MovingPoint& b, double radius_m, Tick tick,
                  Examined& examined) {
  const Vec3& axis = solid_below.normal;
  const double excess_m =
      math::dot(axis, b.position_m) - solid_below.offset_m - radius_m - k_touch_m;
  if (!(excess_m > k_well_apart * radius_m)) return false;
  examined = look_after(tick, first_zero_s(excess_m, math::dot(axis, b.velocity_mps),
                                           math::dot(axis, b.acceleration_mps2)));
  return true;
}

Examined examine_pieces(const MovingPiece& a, const MovingPiece& b, Tick tick, double touch_m,
                        SeparationCache& cache, PieceContact& contact) {
  if (is_round(a) || is_round(b)) return examine_round(a, b, tick, touch_m, cache, contact);
  if (!cache.filled) {
    // First try a guessed axis. A guess is cheap and may show that the pieces are well apart.
    Shadows guess(a, b, guessed_axis(a, b));
    const double smaller_m = std::min(a.reach_m + a.radius_m, b.reach_m + b.radius_m);
    const double gap_m = guess.gap_m(a, b);
    if (gap_m > k_well_apart * smaller_m) {
      Examined apart = look_after(tick, open_for_s(a, b, guess, touch_m, {}));
      apart.gap_m = gap_m;
      return apart;
    }
    cache = {.axis = transposed_product(a.pose.rotation, guess.axis),
             .a = {FeatureKind::vertex, guess.of_a.lowest_vertex()},
             .b = {FeatureKind::vertex, guess.of_b.lowest_vertex()},
             .filled = true};
  }
  // Compute the gap. If the pieces nearly touch, compute it again from scratch.
  Closest closest = closest_warm(*a.view, a.pose, *b.view, b.pose, cache);
  if (closest.gap_m - (a.radius_m + b.radius_m) <= touch_m + k_warm_error_m) {
    closest = closest_cold(*a.view, a.pose, *b.view, b.pose, cache);
    contact = contact_from(closest, a, b);
    if (collides(contact, touch_m)) return {.collides = true, .next = tick};
  }

  // Compute how long the pieces can't collide. Use fixed axes and axes that turn with the features.
  const Vec3 contact_m = 0.5 * (closest.point_a_m + closest.point_b_m);
  const double gap_m = closest.gap_m - (a.radius_m + b.radius_m);
  const auto turn_with_features = [&]() -> AxisTurn {
    const Vec3 turning = turn_of_axis(a, b, closest);
    return is_zero(turning) ? AxisTurn{} : turning_axis(a, b, contact_m, turning);
  };
  Shadows shadows(a, b, closest.normal);
  double span_s = 0;
  if (touches(gap_m, touch_m)) {
    span_s = std::min(touching_for_s(a, b, shadows, touch_m, turn_with_features()),
                      comes_deeper_s(a, b, closest.normal));
  } else {
    span_s = open_for_s(a, b, shadows, touch_m, {});
    if (span_s < k_long_enough_s) {
      const AxisTurn turn = turn_with_features();
      if (!is_zero(turn.angular_velocity_radps))
        span_s = std::max(span_s, open_for_s(a, b, shadows, touch_m, turn));
    }
  }
  if (span_s < k_long_enough_s) span_s = std::max(span_s, too_slow_for_s(a, b));
  Examined apart = look_after(tick, span_s);
  apart.gap_m = gap_m;
  return apart;
}

Examined examine_plane(const HalfSpace& solid_below, const MovingPiece& b, Tick tick,
                       double touch_m, PieceContact& contact) {
  if (is_round(b)) return examine_round_plane(solid_below, b, tick, touch_m, contact);
  const Vec3& axis = solid_below.normal;
  const Line base{math::dot(axis, b.pose.position_m) - solid_below.offset_m - b.radius_m +
                      (k_touch_m - touch_m) - rounding_m(solid_below, b),
                  math::dot(axis, b.velocity_mps)};
  const double pull = math::dot(axis, b.acceleration_mps2);
  Envelope of_b(b, axis);
  bool in_touch = false;
  if (base.place_m + of_b.lowest_m() <= k_touch_m + k_warm_error_m) {
    contact = contact_of(solid_below, b);
    if (collides(contact, touch_m)) return {.collides = true, .next = tick};
    in_touch = touches(contact.gap_m, touch_m);
  }
  const double fall = std::max(0.0, b.turning_acceleration_mps2 - pull);
  of_b.turn(Vec3::Zero());
  double from_s = 0;
  double span_s = k_forever_s;
  if (in_touch) {
    from_s = comes_out_s(sum_of(base, k_no_line, of_b.first()), fall);
    span_s =
        touching_along(base, fall, b.turning_acceleration_mps2, k_rounding_ulps * b.view->r_outer_m,
                       nullptr, of_b, std::min(k_touching_s, from_s));
    of_b.turn(Vec3::Zero());
  }
  if (span_s >= from_s) span_s = comes_down_s(base, fall, nullptr, of_b, from_s);
  const double sphere_m = base.place_m - b.reach_m - k_touch_m;
  if (sphere_m > 0) span_s = std::max(span_s, first_zero_s(sphere_m, base.rate_mps, pull));
  if (span_s < k_long_enough_s) {
    MovingPiece still;
    still.view = b.view;
    span_s = std::max(span_s, too_slow_for_s(still, b));
  }
  return look_after(tick, span_s);
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
