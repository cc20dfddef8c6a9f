// Free rotation of a body with three different principal moments, by steps of a Taylor series.
//
// Idea. About the body's own axes, Euler's equations and the kinematics of the quaternion are
// bilinear,
//   dw1/dt = (I2 - I3)/I1 w2 w3 (and cyclic),   dq/dt = q (0; w)/2,
// so the Taylor coefficients follow from one another by sums of products. With time in units of the
// step, W = h w:
//   (n+1) W1[n+1] = (I2 - I3)/I1 sum over k of W2[k] W3[n-k],   (n+1) Q[n+1] = sum of Q[k]
//   W[n-k]/2.
// The polynomial of a step is also what is evaluated inside it.
//
// The step is a power of two of ticks, the greatest with h |w|max max(1, c) <= 1/4, where |w|max is
// the greatest angular speed on the polhode (rotation_bounds.h) and c the greatest coefficient of
// Euler's equations, at most 1 for real masses. The poles of w(t) then lie six steps or more from
// the real axis, and cutting off after order 16 costs less than 7e-17 (the greatest sum of left-out
// terms of 4,000 bodies, plates and needles and flips among them).
//
// Invariants
//   1. Step k is a function of the flight and k alone: always reached from the flight's own start,
//      through the same steps. So results do not depend on the order of questions.
//   2. At the start of each step the norm of q is 1 to within 2^-51.
// Near the start of a step fewer terms are needed, and only those are computed: bodies that bounce
// often don't pay for a whole step each time.
// Cost: about 0.4 us for a step, an eighth to a quarter radian at the greatest speed; 15 ns for an
// orientation inside it. A question before the current step, unless about the one just before it,
// starts again from the flight's begin.
// Thread safety: one object is not shared between threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "worker/physics/motion/free_flight.h"

namespace sleight::physics {

/// 169 words, no allocation.
class GeneralRotation {
 public:
  static constexpr std::size_t k_order = 16;
  /// Greatest h |w|max max(1, c), in radians: see above.
  static constexpr double k_step_rad = 0.25;
  /// Steps of one flight: 131,000 rad or more, half a second of computing. What turns for longer
  /// without touching anything is refused: see rotation_horizon in rotation_track.h.
  static constexpr std::int64_t k_steps_max = std::int64_t{1} << 20;

  /// REQUIRES: moments > 0; orientation of norm 1; everything finite.
  GeneralRotation(const FreeFlight& flight, const Inertia& inertia);

  /// Ticks after begin up to which questions are allowed: k_steps_max steps, at most k_tick_max; 0
  /// for bodies so fast that a tick is too long for a step (2^28 rad/s).
  TickCount span_max() const { return span_max_; }

  /// q at a time after begin. REQUIRES: 0 <= ticks <= span_max().
  Quat orientation_at(TickCount ticks_since_begin);
  /// w in the world's frame. REQUIRES: the same.
  Vec3 angular_velocity_at(TickCount ticks_since_begin);

 private:
  /// At the start of a step, each number as an unrounded sum of two: else the rounding of a long
  /// flight's steps would add up in energy and angular momentum.
  struct State {
    std::array<double, 4> q{};  ///< w, x, y, z
    std::array<double, 3> w{};  ///< radians per step, about the body's axes
    std::array<double, 4> q_low{};
    std::array<double, 3> w_low{};
  };

  double offset_in(TickCount ticks_since_begin) const;
  void seek(TickCount ticks_since_begin);
  void advance();
  void begin_step();
  void expand(std::size_t order);

  // Coefficients of the current step, lowest order first.
  std::array<std::array<double, 4>, k_order + 1> q_{};
  std::array<std::array<double, 3>, k_order + 1> w_{};
  std::array<double, 3> euler_{};  ///< (I2 - I3)/I1 and cyclic
  State first_;                    ///< of step 0
  State previous_;                 ///< of step_ - 1
  State state_;                    ///< of step_
  std::size_t expanded_ = 0;       ///< coefficients up to this order are there
  std::int64_t step_ = 0;
  TickCount span_max_ = 0;
  int log2_ticks_ = 0;  ///< of a step
  bool has_previous_ = false;
  double steps_per_second_ = 0;
};

}  // namespace sleight::physics
