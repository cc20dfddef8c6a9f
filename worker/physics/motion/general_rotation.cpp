#include "worker/physics/motion/general_rotation.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "worker/physics/motion/invariants.h"
#include "worker/physics/motion/rotation_bounds.h"

namespace sleight::physics {

namespace {

/// Returns log2 of the step in ticks, or a negative number if the step is shorter than a tick.
int log2_step_ticks(double rate_radps) {
  constexpr int k_longest = 52;
  const double ticks = GeneralRotation::k_step_rad / rate_radps * k_ticks_per_second;
  if (!(ticks < static_cast<double>(k_tick_max.value))) return k_longest;
  int exponent = 0;
  std::frexp(ticks, &exponent);  // ticks is in [1/2, 1) times 2^exponent
  return exponent - 1;
}

template <std::size_t axes>
using Coefficients = std::array<std::array<double, axes>, GeneralRotation::k_order + 1>;

/// Returns a polynomial order that is high enough for an offset in a step. Term n is at most 2^-2n
/// x^n times the first term, and the terms that a lower order omits stay below 2^-56. Depends only
/// on the offset.
std::size_t order_for(double x) {
  if (x <= 0x1p-10) return 4;
  if (x <= 0x1p-5) return 8;
  if (x <= 0x1p-3) return 12;
  return GeneralRotation::k_order;
}

/// Evaluates a polynomial of even order without its constant term. Even and odd powers are summed
/// separately, which halves the chain of dependent operations.
template <std::size_t axes>
std::array<double, axes> change(const Coefficients<axes>& c, double x, std::size_t n) {
  const double square = x * x;
  std::array<double, axes> even = c[n];
  std::array<double, axes> odd = c[n - 1];
  for (std::size_t k = n - 2; k > 0; k -= 2) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      even[axis] = even[axis] * square + c[k][axis];
      odd[axis] = odd[axis] * square + c[k - 1][axis];
    }
  }
  for (std::size_t axis = 0; axis < axes; ++axis)
    odd[axis] = odd[axis] * x + even[axis] * square;
  return odd;
}

template <std::size_t axes>
std::array<double, axes> value(const Coefficients<axes>& c, double x, std::size_t order) {
  std::array<double, axes> result = change(c, x, order);
  for (std::size_t axis = 0; axis < axes; ++axis)
    result[axis] = c[0][axis] + result[axis];
  return result;
}

/// Adds a change to the sum high + low, and stores the rounding error of `high` in `low` (Knuth,
/// "The art of computer programming", volume 2, section 4.2.2, theorem B).
template <std::size_t axes>
void add(const std::array<double, axes>& change, std::array<double, axes>& high,
         std::array<double, axes>& low) {
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const double a = high[axis];
    const double b = change[axis] + low[axis];
    const double sum = a + b;
    const double b_seen = sum - a;
    low[axis] = (a - (sum - b_seen)) + (b - b_seen);
    high[axis] = sum;
  }
}

}  // namespace

GeneralRotation::GeneralRotation(const FreeFlight& flight, const Inertia& inertia) {
  const Vec3& moments = inertia.principal_kgm2;
  const Vec3 body = body_angular_velocity_radps(flight.orientation, flight.angular_velocity_radps);
  const double speed = general_rotation_bounds(moments, body).angular_speed_radps;
  CHECK(std::isfinite(speed) && moments.x() > 0 && moments.y() > 0 && moments.z() > 0);
  euler_ = {(moments.y() - moments.z()) / moments.x(), (moments.z() - moments.x()) / moments.y(),
            (moments.x() - moments.y()) / moments.z()};
  const double coupling =
      std::max({1.0, std::fabs(euler_[0]), std::fabs(euler_[1]), std::fabs(euler_[2])});

  const int log2_ticks = log2_step_ticks(speed * coupling);
  if (log2_ticks >= 0) {
    log2_ticks_ = log2_ticks;
    span_max_ = log2_ticks >= 32 ? k_tick_max.value : k_steps_max << log2_ticks;
  }
  steps_per_second_ = std::ldexp(k_ticks_per_second, -log2_ticks_);
  const double seconds_per_step = 1 / steps_per_second_;  // powers of two: exact
  state_ = {
      .q = {flight.orientation.w(), flight.orientation.x(), flight.orientation.y(),
            flight.orientation.z()},
      .w = {body.x() * seconds_per_step, body.y() * seconds_per_step, body.z() * seconds_per_step}};
  first_ = state_;
  begin_step();
}

Quat GeneralRotation::orientation_at(TickCount ticks_since_begin) {
  seek(ticks_since_begin);
  const double offset = offset_in(ticks_since_begin);
  const std::size_t order = order_for(offset);
  expand(order);
  const std::array<double, 4> q = value(q_, offset, order);
  return {q[0], q[1], q[2], q[3]};
}

Vec3 GeneralRotation::angular_velocity_at(TickCount ticks_since_begin) {
  seek(ticks_since_begin);
  const double offset = offset_in(ticks_since_begin);
  const std::size_t order = order_for(offset);
  expand(order);
  const std::array<double, 4> q = value(q_, offset, order);
  const std::array<double, 3> w = value(w_, offset, order);
  return math::rotated(
      Quat(q[0], q[1], q[2], q[3]),
      Vec3(w[0] * steps_per_second_, w[1] * steps_per_second_, w[2] * steps_per_second_));
}

/// Returns the time since the current step began, as an exact share of the step, from 0 to 1.
double GeneralRotation::offset_in(TickCount ticks_since_begin) const {
  const TickCount ticks = ticks_since_begin - (step_ << log2_ticks_);
  return seconds(ticks) * steps_per_second_;
}

void GeneralRotation::seek(TickCount ticks_since_begin) {
  const std::int64_t step = ticks_since_begin >> log2_ticks_;
  if (step == step_ && ticks_since_begin <= span_max_) return;
  CHECK_GE(ticks_since_begin, 0);
  CHECK_LE(ticks_since_begin, span_max_);
  if (step < step_) {
    const bool one_back = has_previous_ && step == step_ - 1;
    step_ = one_back ? step : 0;
    has_previous_ = false;
    state_ = one_back ? previous_ : first_;
    begin_step();
  }
  while (step_ < step)
    advance();
}

void GeneralRotation::advance() {
  previous_ = state_;
  has_previous_ = true;
  expand(k_order);
  add(change(q_, 1, k_order), state_.q, state_.q_low);
  add(change(w_, 1, k_order), state_.w, state_.w_low);
  // Bring the norm of q closer to 1 by a Newton step. Only the low part of q changes.
  const std::array<double, 4>& q = state_.q;
  std::array<double, 4>& low = state_.q_low;
  const double square = ((q[0] * q[0] + q[1] * q[1]) + q[2] * q[2]) + q[3] * q[3];
  const double along_low = ((q[0] * low[0] + q[1] * low[1]) + q[2] * low[2]) + q[3] * low[3];
  const double excess = 0.5 * (square - 1) + along_low;
  for (std::size_t axis = 0; axis < 4; ++axis)
    low[axis] -= q[axis] * excess;
  begin_step();
  ++step_;
}

void GeneralRotation::begin_step() {
  q_[0] = state_.q;
  w_[0] = state_.w;
  expanded_ = 0;
}

/// Computes the step's missing coefficients up to an order.
void GeneralRotation::expand(std::size_t order) {
  for (std::size_t n = expanded_; n < order; ++n) {
    std::array<double, 3> w{};
    std::array<double, 4> q{};
    for (std::size_t k = 0; k <= n; ++k) {
      const std::array<double, 4>& a = q_[k];
      const std::array<double, 3>& u = w_[k];
      const std::array<double, 3>& v = w_[n - k];
      w[0] += u[1] * v[2];
      w[1] += u[2] * v[0];
      w[2] += u[0] * v[1];
      q[0] -= (a[1] * v[0] + a[2] * v[1]) + a[3] * v[2];
      q[1] += (a[0] * v[0] + a[2] * v[2]) - a[3] * v[1];
      q[2] += (a[0] * v[1] + a[3] * v[0]) - a[1] * v[2];
      q[3] += (a[0] * v[2] + a[1] * v[1]) - a[2] * v[0];
    }
    const double share = 1.0 / static_cast<double>(n + 1);
    for (std::size_t axis = 0; axis < 3; ++axis)
      w_[n + 1][axis] = w[axis] * (euler_[axis] * share);
    for (std::size_t axis = 0; axis < 4; ++axis)
      q_[n + 1][axis] = q[axis] * (0.5 * share);
  }
  expanded_ = std::max(expanded_, order);
}

}  // namespace sleight::physics
