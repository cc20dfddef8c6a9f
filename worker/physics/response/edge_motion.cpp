#include "worker/physics/response/edge_motion.h"

#include <algorithm>
#include <cmath>

#include "common/math/vector.h"
#include "worker/physics/event/tolerances.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

/// Returns the cube root of x in [0, 1], slightly too large: Newton's method from above.
double cube_root_above(double x) {
  double root = std::sqrt(std::sqrt(x));
  for (int i = 0; i < 16 && root > 0; ++i) {
    const double next = (2 * root + x / (root * root)) / 3;
    if (!(next < 0.99 * root)) return next;
    root = next;
  }
  return root;
}

/// Per mass.
double kinetic_energy(const RoundBody& body, const Twist& twist) {
  const Vec3& v = twist.velocity_mps;
  const Vec3& w = twist.angular_velocity_radps;
  return 0.5 * (dot(v, v) + body.gyration * body.radius_m * body.radius_m * dot(w, w));
}

Twist scaled(double share, const Twist& twist) {
  return {.velocity_mps = share * twist.velocity_mps,
          .angular_velocity_radps = share * twist.angular_velocity_radps};
}

/// Adjusts the twist of a rolling sphere to a turned normal. The surface would slip a little;
/// friction stops this slip without taking energy.
void keep_rolling(const RoundBody& body, const Vec3& normal, Twist& twist) {
  const double before = kinetic_energy(body, twist);
  stop_slip(body, normal, twist);
  const double after = kinetic_energy(body, twist);
  if (after > 0) twist = scaled(std::sqrt(before / after), twist);
}

/// A centre's parabola over a chord, in the plane across the edge.
struct Arch {
  double chord_m;
  double height_m;  ///< of the chord above the edge
  double along_mps;
  double up_mps;
  double along_mps2;
  double up_mps2;
  double lasts_s;
};

/// Returns the maximum rise above the cylinder. At time t, the squared distance exceeds its value
/// at the ends by t (T - t) q(t), where q has degree two.
double most_rise_m(const Arch& arch, double distance_m) {
  const double x_m = -0.5 * arch.chord_m;
  const double c_2 = arch.along_mps * arch.along_mps + arch.up_mps * arch.up_mps +
                     x_m * arch.along_mps2 + arch.height_m * arch.up_mps2;
  const double c_3 = arch.along_mps * arch.along_mps2 + arch.up_mps * arch.up_mps2;
  const double c_4 = 0.25 * (arch.along_mps2 * arch.along_mps2 + arch.up_mps2 * arch.up_mps2);
  const double span_s = arch.lasts_s;
  const double q_2 = -c_4;
  const double q_1 = span_s * q_2 - c_3;
  const double q_0 = span_s * q_1 - c_2;
  const double top_s = q_2 < 0 ? std::clamp(-q_1 / (2 * q_2), 0.0, span_s) : 0;
  const double most =
      std::max(q_0 + top_s * (q_1 + top_s * q_2), q_0 + span_s * (q_1 + span_s * q_2));
  return 0.125 * span_s * span_s * most / distance_m;
}

/// The plane that is tangent half way through a piece, and the sphere's motion on this plane.
struct HalfWay {
  double sine;
  double cosine;
  Vec3 normal;
  Vec3 tangent;
  ContactMotion motion;
};

/// A sphere at the start of a piece.
struct Rider {
  const RoundBody& body;
  const LastingContact& contact;
  const EdgeLine& edge;
  const Vec3& spin_radps;
  Vec3 onwards;       ///< unit, perpendicular to edge and normal
  double around_mps;  ///< speed along `onwards`
  double along_mps;   ///< speed along the edge
  bool rolls;
};

HalfWay half_way_of(const Rider& rider, double sine, const Vec3& gravity_mps2) {
  const Vec3& outwards = rider.contact.normal;
  const Vec3& w = rider.spin_radps;
  const double cosine = std::sqrt(1 - sine * sine);
  LastingContact there = rider.contact;
  there.normal = cosine * outwards + sine * rider.onwards;
  const Vec3 tangent = cosine * rider.onwards - sine * outwards;
  Twist twist{.velocity_mps = rider.around_mps * tangent + rider.along_mps * rider.edge.direction,
              .angular_velocity_radps = w};
  if (rider.rolls) {
    keep_rolling(rider.body, there.normal, twist);
  } else {
    // Turn the spin with the normal, so that the slip turns in the same way.
    twist.angular_velocity_radps += dot(w, outwards) * (there.normal - outwards) +
                                    dot(w, rider.onwards) * (tangent - rider.onwards);
  }
  const double forwards_mps = dot(tangent, twist.velocity_mps);
  const Vec3 lightened_mps2 =
      gravity_mps2 + (forwards_mps * forwards_mps / rider.edge.distance_m) * there.normal;
  return {.sine = sine,
          .cosine = cosine,
          .normal = there.normal,
          .tangent = tangent,
          .motion = contact_motion(rider.body, std::span(&there, 1), twist, lightened_mps2)};
}

EdgePiece piece_on(const HalfWay& plane) {
  return {.start = plane.motion.start,
          .acceleration_mps2 = plane.motion.acceleration_mps2,
          .angular_acceleration_radps2 = plane.motion.angular_acceleration_radps2,
          .half_way = plane.normal,
          .rolls = plane.motion.rolls};
}

/// Returns a piece in which the sphere rolls up along the tangent and then back to the start.
std::optional<EdgePiece> there_and_back(const HalfWay& plane) {
  const double v = dot(plane.tangent, plane.motion.start.velocity_mps);
  const double a = dot(plane.tangent, plane.motion.acceleration_mps2);
  if (!(v > 0) || !(a < 0) || !plane.motion.rolls) return std::nullopt;
  EdgePiece piece = piece_on(plane);
  piece.lasts_s = 2 * v / -a;
  if (!(piece.lasts_s <= plane.motion.lasts_s)) return std::nullopt;
  return piece;
}

/// A piece, or the factor by which the next attempt reduces the sine.
struct Attempt {
  std::optional<EdgePiece> piece = std::nullopt;
  double shorter = 0;  ///< 0: no shorter piece helps
};

Attempt attempt_on(const HalfWay& plane, double distance_m, double rise_max_m) {
  const ContactMotion& motion = plane.motion;
  const double sine = plane.sine;
  const double cosine = plane.cosine;
  const double v = dot(plane.tangent, motion.start.velocity_mps);
  const double a = dot(plane.tangent, motion.acceleration_mps2);
  if (!(v > 0)) return {};
  const double chord_m = 2 * distance_m * sine;
  const double gained = 2 * a * chord_m;  // gain of the squared speed
  double first_square = cosine * cosine * v * v;
  if (a > 0) first_square -= sine * sine * gained;
  const double last_square = first_square + gained;
  if (!(first_square >= (1 - k_edge_piece_turned_max) * v * v) || !(last_square > 0))
    return {.shorter = 0.5};
  const double first_mps = std::sqrt(first_square);
  const double last_mps = std::sqrt(last_square);
  const double lasts_s = 2 * chord_m / (first_mps + last_mps);
  const double up_mps = sine / cosine * std::max(first_mps, last_mps);
  const Arch arch{.chord_m = chord_m,
                  .height_m = distance_m * cosine,
                  .along_mps = first_mps,
                  .up_mps = up_mps,
                  .along_mps2 = a,
                  .up_mps2 = -2 * up_mps / lasts_s,
                  .lasts_s = lasts_s};
  if (most_rise_m(arch, distance_m) > rise_max_m) return {.shorter = 0.7};
  if (lasts_s > motion.lasts_s) return {.shorter = 0.95 * motion.lasts_s / lasts_s};
  EdgePiece piece = piece_on(plane);
  // The spin follows the whole speed. The whole speed changes more slowly than its component along
  // the chord.
  const double slower = (first_mps + last_mps) / (v + std::sqrt(v * v + gained));
  const Vec3 turning = cross(plane.normal, plane.tangent);
  piece.angular_acceleration_radps2 +=
      ((slower - 1) * dot(turning, piece.angular_acceleration_radps2)) * turning;
  piece.start.velocity_mps += (first_mps - v) * plane.tangent + up_mps * plane.normal;
  piece.acceleration_mps2 -= (2 * up_mps / lasts_s) * plane.normal;
  piece.lasts_s = lasts_s;
  return {.piece = piece};
}

}  // namespace

std::optional<EdgePiece> edge_piece(const RoundBody& body, const LastingContact& contact,
                                    const EdgeLine& edge, const Twist& twist, bool rolled,
                                    const Vec3& gravity_mps2, double rise_max_m) {
  const double distance_m = edge.distance_m;
  const Vec3& d = edge.direction;
  const Vec3& outwards = contact.normal;
  const double along_mps = dot(d, twist.velocity_mps);
  const Vec3 around_mps = twist.velocity_mps - along_mps * d;
  const double speed_mps = norm(around_mps);
  const double load_mps2 = -dot(gravity_mps2, outwards);
  if (!(speed_mps > 0) || !(load_mps2 > 0)) return std::nullopt;
  Vec3 onwards = cross(d, outwards);
  if (dot(onwards, around_mps) < 0) onwards = -onwards;
  const Vec3& w = twist.angular_velocity_radps;
  const Vec3 slip = twist.velocity_mps - dot(outwards, twist.velocity_mps) * outwards -
                    body.radius_m * cross(w, outwards);
  const bool rolls = rolled || norm(slip) <= body.stick_mps;
  const Rider rider{.body = body,
                    .contact = contact,
                    .edge = edge,
                    .spin_radps = w,
                    .onwards = onwards,
                    .around_mps = speed_mps,
                    .along_mps = along_mps,
                    .rolls = rolls};

  // Gravity accelerates or brakes the sphere along its path. If the sphere slips, friction does so
  // too.
  const double pull_mps2 = dot(gravity_mps2, onwards);
  const double rolling_mps2 = pull_mps2 / (1 + body.gyration);
  const double most_mps2 =
      rolls ? std::fabs(rolling_mps2) : std::fabs(pull_mps2) + contact.friction * load_mps2;
  // The rise is about a h T^2 / 4, where T = 2 D h / v and a grows with h.
  const double scaled_mps2 = rise_max_m * speed_mps * speed_mps / (distance_m * distance_m);
  double sine = k_edge_piece_sine_max;
  if (scaled_mps2 < most_mps2 * sine * sine * sine) sine = cube_root_above(scaled_mps2 / most_mps2);
  sine = k_edge_piece_first *
         std::min(sine, std::sqrt(std::sqrt(scaled_mps2 * (1 + body.gyration) / load_mps2)));
  if (rolls && rolling_mps2 < 0) {
    const double way_m = 0.5 * speed_mps * speed_mps / -rolling_mps2;
    if (way_m * way_m <= 2 * distance_m * rise_max_m) {
      const HalfWay plane = half_way_of(rider, 0, gravity_mps2);
      return plane.motion.pressed != 0 ? there_and_back(plane) : std::nullopt;
    }
    sine = std::min(sine, k_edge_piece_before_turn * way_m / distance_m);
  }
  for (int tries = 0; tries < k_edge_piece_tries_max && sine >= k_edge_piece_sine_min; ++tries) {
    const HalfWay plane = half_way_of(rider, sine, gravity_mps2);
    if (plane.motion.pressed == 0) return std::nullopt;
    Attempt attempt = attempt_on(plane, distance_m, rise_max_m);
    if (attempt.piece || attempt.shorter == 0) return attempt.piece;
    sine *= attempt.shorter;
  }
  return std::nullopt;
}

Twist without_lift(const RoundBody& body, const EdgeFlight& flight, const Vec3& gravity_mps2,
                   const Vec3& moved_m, const Twist& twist) {
  const double energy = kinetic_energy(body, twist);
  const double lifted =
      dot(flight.acceleration_mps2 - gravity_mps2, flight.half_way) * dot(flight.half_way, moved_m);
  const double had = kinetic_energy(body, flight.start) + dot(gravity_mps2, moved_m);
  const double has = std::max(0.0, std::min(energy - std::max(0.0, lifted), had));
  if (!(has < energy)) return twist;
  return scaled(std::sqrt(has / energy), twist);
}

}  // namespace sleight::physics
