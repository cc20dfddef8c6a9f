// Chooses one direction in which friction acts on a slip for a while, and the duration.
//
// Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/vector.h"
#include "worker/physics/event/tick.h"
#include "worker/physics/event/tolerances.h"
#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

struct HeldSlip {
  Vec3 direction = Vec3::Zero();
  double lasts_s = k_forever_s;
};

/// A pull changes a slip while friction acts in one held direction. Returns this direction, which
/// is the slip's direction halfway through `lasts_s`. (If the held direction depended on the
/// initial one, it would oscillate from piece to piece, as friction doesn't turn a slip.)
/// `error_mps`: permitted error of the slip.
inline HeldSlip held_slip(const Vec3& slip, const Vec3& pull, double brake, double error_mps) {
  const double speed = math::norm(slip);
  const Vec3 direction = slip / speed;
  const double forward = math::dot(pull, direction);
  const double across = math::norm(pull - forward * direction);
  const double stop_s = forward < brake ? speed / (brake - forward) : k_forever_s;
  if (across == 0 || across * stop_s <= k_slip_straight * speed ||
      (forward > 0 && across <= k_slip_straight * forward))
    return {direction, stop_s};
  // The held direction is the slip's direction halfway through the time. So the error is friction's
  // change of the slip, times the square of the turn. Within `stops` stopping times, this change is
  // at most `stops` times the slip. Within the time of the turn, it is at most brake / across times
  // the slip. Use the bound that allows the longer time.
  const auto span_of = [&](double turn_squared, double stops) {
    const double turn = std::clamp(std::sqrt(turn_squared), k_slip_turn_rad, k_slip_turn_rad_max);
    return std::min({turn * speed / across, stops * speed / brake, stop_s});
  };
  const double allowed = std::max(error_mps, k_slip_turn_rad * k_slip_turn_rad * speed) / speed;
  const double span_s =
      std::max(span_of(allowed, 1), span_of(allowed * across / brake, k_slip_stops));
  return {math::normalized(slip + (0.5 * span_s) * pull), span_s};
}

/// Returns the time at which a velocity's component along a direction becomes 0.
inline double stop_s(const Vec3& velocity, const Vec3& rate, const Vec3& direction) {
  const double along = math::dot(rate, direction);
  return along < 0 ? std::max(0.0, math::dot(velocity, direction)) / -along : k_forever_s;
}

}  // namespace sleight::physics
