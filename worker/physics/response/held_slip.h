// The direction in which friction acts on a slip for a while, and for how long.
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

/// Of a slip that a pull changes and friction brakes: half way, under the friction that acts along
/// the direction held, it has that direction. (Friction doesn't turn a slip; the direction held
/// would swing also if its direction at the start had a part in it.)
/// `error_mps`: what doesn't matter, of the slip.
inline HeldSlip held_slip(const Vec3& slip, const Vec3& pull, double brake, double error_mps) {
  const double speed = math::norm(slip);
  const Vec3 direction = slip / speed;
  const double forward = math::dot(pull, direction);
  const double across = math::norm(pull - forward * direction);
  const double stop_s = forward < brake ? speed / (brake - forward) : k_forever_s;
  if (across == 0 || across * stop_s <= k_slip_straight * speed ||
      (forward > 0 && across <= k_slip_straight * forward))
    return {direction, stop_s};
  // Half way the direction is right, so a turn does wrong what friction does meanwhile, times its
  // square. In `stops` times its stopping time friction does so many times the slip; in the time
  // that the turn takes, at most brake / across times the slip. Whichever allows more.
  const auto span_of = [&](double turn_squared, double stops) {
    const double turn = std::clamp(std::sqrt(turn_squared), k_slip_turn_rad, k_slip_turn_rad_max);
    return std::min({turn * speed / across, stops * speed / brake, stop_s});
  };
  const double allowed = std::max(error_mps, k_slip_turn_rad * k_slip_turn_rad * speed) / speed;
  const double span_s =
      std::max(span_of(allowed, 1), span_of(allowed * across / brake, k_slip_stops));
  return {math::normalized(slip + (0.5 * span_s) * pull), span_s};
}

/// When a velocity's part along a direction is 0.
inline double stop_s(const Vec3& velocity, const Vec3& rate, const Vec3& direction) {
  const double along = math::dot(rate, direction);
  return along < 0 ? std::max(0.0, math::dot(velocity, direction)) / -along : k_forever_s;
}

}  // namespace sleight::physics
