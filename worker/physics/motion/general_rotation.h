// Free rotation of a body whose three principal moments differ, computed in steps of a Taylor
// series.
//
// Idea. In the body's frame, Euler's equations and the quaternion's kinematics are bilinear:
//
//   dw1/dt = (I2 - I3)/I1 w2 w3 (and cyclic),   dq/dt = q (0; w)/2.
//
// So each Taylor coefficient is a sum of products of lower ones. If time is measured in steps, and
// W = h w, sums over k from 0 to n give
//
//   (n+1) W1[n+1] = (I2 - I3)/I1 sum of W2[k] W3[n-k]
//   (n+1) Q[n+1]  = sum of Q[k] W[n-k]/2.
//
// A step's polynomial is also evaluated inside the step.
//
// The step h, in ticks, is the greatest power of two for which h |w|max max(1, c) <= 1/4. Here
// |w|max is the greatest angular speed on the polhode (rotation_bounds.h). The greatest coefficient
// of Euler's equations is c; it is at most 1 for real masses. The poles of w(t) are then at least
// six steps from the real axis. Terms above order 16 are omitted: their sum was below 7e-17 for
// each of 4,000 tested bodies, including plates, needles and flips.
//
// Invariants
//   1. Step k depends only on the flight and k, because the same steps always lead to it from the
//      flight's start. So results do not depend on the order of calls.
//   2. At the start of each step the norm of q is 1 to within 2^-51.
// Near the start of a step, fewer terms are needed, and only those are computed. So a body that
// bounces often doesn't pay for whole steps. Cost: about 0.4 us per step, and 15 ns per orientation
// inside a step. At the greatest speed, the body turns by 1/8 to 1/4 radian in a step. If a call is
// for an earlier time, the steps restart at the flight's start, unless that time is in the step
// just before the current one.
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
  /// Maximum of h |w|max max(1, c), in radians.
  static constexpr double k_step_rad = 0.25;
  /// Maximum steps of a flight. These steps cover at least 131,000 rad and take half a second to
  /// compute. If a body turns for longer without a contact, it is refused (rotation_horizon in
  /// rotation_track.h).
  static constexpr std::int64_t k_steps_max = std::int64_t{1} << 20;

  /// REQUIRES: moments > 0; orientation of norm 1; everything finite.
  GeneralRotation(const FreeFlight& flight, const Inertia& inertia);

  /// The rotation can be evaluated up to this time after the flight's start: k_steps_max steps, but
  /// at most k_tick_max. 0 if the step would be shorter than a tick (2^28 rad/s).
  TickCount span_max() const { return span_max_; }

  /// Returns q at a time after the flight's start. REQUIRES: 0 <= ticks <= span_max().
  Quat orientation_at(TickCount ticks_since_begin);
  /// Returns w in the world's frame. REQUIRES: 0 <= ticks <= span_max().
  Vec3 angular_velocity_at(TickCount ticks_since_begin);

 private:
  /// State at the start of a step. Each number is stored as the unrounded sum of two doubles. If
  /// each number were one double, a long flight's rounding errors would add up in energy and
  /// angular momentum.
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
  State first_;                    ///< at step 0
  State previous_;                 ///< at step_ - 1
  State state_;                    ///< at step_
  std::size_t expanded_ = 0;       ///< coefficients up to this order are computed
  std::int64_t step_ = 0;
  TickCount span_max_ = 0;
  int log2_ticks_ = 0;  ///< log2 of the ticks in a step
  bool has_previous_ = false;
  double steps_per_second_ = 0;
};

}  // namespace sleight::physics
