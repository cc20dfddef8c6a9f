#include "worker/physics/response/plane_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/math/elementary.h"
#include "common/math/vector.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/response/held_slip.h"
#include "worker/physics/response/plane_loads.h"
#include "worker/physics/response/plane_rolling.h"

namespace sleight::physics {
namespace {

using math::cross;
using math::dot;
using math::norm;

/// Turns a vector about the plane's normal. REQUIRES: the vector is parallel to the plane.
Vec3 turned_about(const Vec3& n, const Vec3& v, const math::SinCos& angle) {
  return angle.cos * v + angle.sin * cross(n, v);
}

/// A body lying on an area, at the start of a piece.
class Slide {
 public:
  Slide(const BodyOnPlane& body, const Twist& twist, const Vec3& pull_mps2, double load_mps2)
      : body_(body), pull_mps2_(pull_mps2), load_mps2_(load_mps2), lying_(body, load_mps2) {
    const Vec3& n = body.normal;
    velocity_mps_ = twist.velocity_mps - dot(twist.velocity_mps, n) * n;
    spin_radps_ = dot(n, math::product(body.inertia_kgm2, twist.angular_velocity_radps)) /
                  lying_.spin_inertia_kgm2();
    if (std::fabs(spin_radps_) * lying_.radius_m() <= k_no_spin_slip * body.stick_mps)
      spin_radps_ = 0;
    for (const PlaneSupport& support : body.supports)
      frictionless_ = frictionless_ && support.friction == 0;
  }

  PlaneMotion motion() {
    if (frictionless_) {
      if (!lying_.rates(directions(velocity_mps_, 0), spin_radps_)) return {};
      PlaneMotion motion = moving(pull_mps2_, 0, k_forever_s);
      motion.stands = norm(velocity_mps_) == 0 && spin_radps_ == 0 && norm(pull_mps2_) == 0;
      return motion;
    }
    double fastest_mps = 0;
    for (std::size_t i = 0; i < body_.supports.size(); ++i)
      fastest_mps = std::max(fastest_mps, norm(lying_.slip_mps(i, velocity_mps_, spin_radps_)));
    if (fastest_mps <= body_.stick_mps) return from_rest();
    if (const auto spins = only_spins()) return *spins;
    return slides();
  }

 private:
  using Directions = LyingBody::Directions;
  using Rates = LyingBody::Rates;

  Directions directions(const Vec3& velocity_mps, double spin_radps) const {
    Directions all;
    for (std::size_t i = 0; i < body_.supports.size(); ++i) {
      const Vec3 slip = lying_.slip_mps(i, velocity_mps, spin_radps);
      all[i] = slip / std::max(norm(slip), k_full_friction_slip * body_.stick_mps);
    }
    return all;
  }

  PlaneMotion moving(const Vec3& acceleration_mps2, double spin_radps2, double lasts_s) const {
    return {.carried = true,
            .brakes = !frictionless_,
            .start = {.velocity_mps = velocity_mps_,
                      .angular_velocity_radps = spin_radps_ * body_.normal},
            .acceleration_mps2 = acceleration_mps2,
            .angular_acceleration_radps2 = spin_radps2 * body_.normal,
            .lasts_s = lasts_s};
  }

  /// Returns the change of the spin, or 0 if it is only rounding, so that a straight slide stays
  /// straight.
  double turning(const Rates& rates) const {
    return std::fabs(rates.spin_radps2) * lying_.radius_m() <= k_load_rounding * load_mps2_
               ? 0
               : rates.spin_radps2;
  }

  /// Returns the motion of a body that doesn't slip anywhere now: friction holds it, or it starts
  /// to slide.
  PlaneMotion from_rest() {
    velocity_mps_ = Vec3::Zero();
    spin_radps_ = 0;
    const double needed = norm(pull_mps2_) / load_mps2_;
    Directions held;
    for (std::size_t i = 0; i < body_.supports.size(); ++i) {
      const double friction = body_.supports[i].friction;
      held[i] = friction > 0 ? Vec3(pull_mps2_ / (load_mps2_ * friction)) : Vec3(Vec3::Zero());
    }
    const auto standing = lying_.rates(held, 0);
    if (!standing) return {};
    double least = k_forever_s;
    double most = 0;
    for (std::size_t i = 0; i < body_.supports.size(); ++i) {
      if (!(standing->loads[i] > 0)) continue;
      least = std::min(least, body_.supports[i].friction);
      most = std::max(most, body_.supports[i].friction);
    }
    if (needed <= least) {
      PlaneMotion still = moving(Vec3::Zero(), 0, k_forever_s);
      still.stands = true;
      still.brakes = false;
      return still;
    }
    // If only some supports stick, refuse the body, because it may swing about them.
    if (least < most) return {};
    const Vec3 down = pull_mps2_ / norm(pull_mps2_);
    held.fill(down);
    const auto sliding = lying_.rates(held, 0);
    if (!sliding) return {};
    if (turning(*sliding) != 0) return {};
    return moving(pull_mps2_ + sliding->acceleration_mps2, 0, k_forever_s);
  }

  /// Returns the motion of a body that only turns on the spot. In the body's frame, its slips don't
  /// turn.
  std::optional<PlaneMotion> only_spins() {
    if (norm(velocity_mps_) > body_.stick_mps || norm(pull_mps2_) > k_load_rounding * load_mps2_)
      return std::nullopt;
    const auto rates = lying_.rates(directions(Vec3::Zero(), spin_radps_), spin_radps_);
    if (!rates || norm(rates->acceleration_mps2) > k_load_rounding * load_mps2_)
      return std::nullopt;
    velocity_mps_ = Vec3::Zero();
    const bool brakes = rates->spin_radps2 * spin_radps_ < 0;
    return moving(Vec3::Zero(), rates->spin_radps2,
                  brakes ? spin_radps_ / -rates->spin_radps2 : k_forever_s);
  }

  struct Span {
    double lasts_s = k_forever_s;
    bool straight = true;
  };
  /// Returns how long the slip directions may be treated as constant at these rates of change.
  Span span_of(const Rates& rates) const {
    Span span;
    for (std::size_t i = 0; i < body_.supports.size(); ++i) {
      if (!(rates.loads[i] > 0) || body_.supports[i].friction == 0) continue;
      const Vec3 slip = lying_.slip_mps(i, velocity_mps_, spin_radps_);
      const double speed_mps = norm(slip);
      if (speed_mps <= body_.stick_mps) {
        span.straight = false;
        span.lasts_s = std::min(span.lasts_s, k_slip_uncertain_s);
        continue;
      }
      const Vec3 direction = slip / speed_mps;
      const Vec3 rate = pull_mps2_ + rates.acceleration_mps2 +
                        rates.spin_radps2 * lying_.across_m(i) +
                        spin_radps_ * spin_radps_ * cross(body_.normal, lying_.across_m(i));
      const double along = dot(rate, direction);
      const double across = norm(rate - along * direction);
      double stop_s = along < 0 ? speed_mps / -along : k_forever_s;
      if (across > k_load_rounding * load_mps2_) {
        span.straight = false;
        // The pull across the slip must stay small compared with the slip until the slip ends.
        if (across * stop_s > body_.stick_mps) stop_s *= 0.5;
        span.lasts_s = std::min(
            span.lasts_s, std::max(k_slip_turn_rad * speed_mps / across, k_slide_piece_s_min));
      }
      span.lasts_s = std::min(span.lasts_s, stop_s);
    }
    return span;
  }

  PlaneMotion slides() const {
    const auto now = lying_.rates(directions(velocity_mps_, spin_radps_), spin_radps_);
    if (!now) return {};
    const Vec3 rate_mps2 = pull_mps2_ + now->acceleration_mps2;
    Span span = span_of(*now);
    if (span.straight && spin_radps_ == 0 && turning(*now) == 0)
      return moving(rate_mps2, 0, span.lasts_s);
    span.lasts_s = std::min(span.lasts_s, k_slide_piece_s_max);
    for (int halving = 0; halving <= k_slide_halvings_max; ++halving) {
      // Compute the loads half way through the piece, in a frame that turns with the body.
      const double half_s = 0.5 * span.lasts_s;
      const double spin_radps = spin_radps_ + half_s * now->spin_radps2;
      const double angle = half_s * (spin_radps_ + 0.5 * half_s * now->spin_radps2);
      const math::SinCos turn = math::sincos(angle);
      const Vec3 velocity_mps = velocity_mps_ + half_s * rate_mps2;
      const Vec3 seen_mps =
          turned_about(body_.normal, velocity_mps, {.sin = -turn.sin, .cos = turn.cos});
      const auto rates = lying_.rates(directions(seen_mps, spin_radps), spin_radps);
      if (!rates) return {};
      const Vec3 friction_mps2 = turned_about(body_.normal, rates->acceleration_mps2, turn);
      const PlaneMotion motion =
          moving(pull_mps2_ + friction_mps2, rates->spin_radps2, span.lasts_s);
      if (friction_brakes(motion, friction_mps2, rates->spin_radps2)) return motion;
      span.lasts_s *= 0.5;
    }
    return {};
  }

  /// Returns whether friction takes energy in a piece. Mean speeds suffice for this test, because
  /// friction is constant.
  bool friction_brakes(const PlaneMotion& motion, const Vec3& friction_mps2,
                       double spin_radps2) const {
    const double half_s = 0.5 * motion.lasts_s;
    const Vec3 mean_mps = velocity_mps_ + half_s * motion.acceleration_mps2;
    const double mean_radps = spin_radps_ + half_s * spin_radps2;
    return body_.mass_kg * dot(friction_mps2, mean_mps) +
               lying_.spin_inertia_kgm2() * spin_radps2 * mean_radps <=
           0;
  }

  const BodyOnPlane& body_;
  Vec3 pull_mps2_;  ///< gravity's part along the plane
  double load_mps2_;
  LyingBody lying_;
  Vec3 velocity_mps_ = Vec3::Zero();
  double spin_radps_ = 0;
  bool frictionless_ = true;
};

}  // namespace

PlaneMotion plane_motion(const BodyOnPlane& body, const Twist& twist, const Vec3& gravity_mps2) {
  if (body.supports.size() < 2 || body.supports.size() > k_plane_supports_max) return {};
  const double load_mps2 = -dot(gravity_mps2, body.normal);
  if (!(load_mps2 > 0)) return {};
  const Vec3 pull_mps2 = gravity_mps2 + load_mps2 * body.normal;
  if (const auto line = line_of(body)) return rolling_motion(body, *line, twist, gravity_mps2);
  if (body.supports.size() < 3) return {};
  return Slide(body, twist, pull_mps2, load_mps2).motion();
}

Mat3 inertia_in_world(const Vec3& principal_kgm2, const Quat& orientation) {
  const Mat3 axes = math::matrix_of(orientation);
  Mat3 inertia;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      double sum = 0;
      for (int k = 0; k < 3; ++k)
        sum += axes(row, k) * principal_kgm2[k] * axes(column, k);
      inertia(row, column) = sum;
    }
  }
  return inertia;
}

}  // namespace sleight::physics
