// A piece of a body's recorded motion: a closed-form function of time. Archives store segments.
//
// Every world records motion as segments, so an animation can be shown, searched and exported
// without the world's code or a simulator.
//
//   centre       c(t) = position + velocity s + acceleration s^2 / 2       s = t - start
//   orientation  rotates with angular velocity w(t) = w + a s, in the scene's frame
//
// If a body's motion is more complex, its segments are as short as necessary. An example is a
// tumbling body with unequal moments of inertia.
//
// Units are SI. Times count from the animation's beginning. The scene's frame is right-handed with
// z up (common/scene). Thread safety: values and pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "common/math/rotation.h"
#include "common/math/vector.h"

namespace sleight::motion {

/// How the body moves, in the order of k_mode_names.
enum class Mode : std::uint8_t {
  flying,   ///< under gravity alone
  sliding,  ///< on a fixed thing, with slip
  rolling,  ///< on a fixed thing, without slip
  resting   ///< not moving
};
inline constexpr std::array<std::string_view, 4> k_mode_names{"flying", "sliding", "rolling",
                                                              "resting"};

/// The cause of the segment's start, in the order of k_cause_names.
enum class Cause : std::uint8_t {
  start,  ///< the body enters
  hit,    ///< the body met the partner
  mode,   ///< the body begins to slide, roll or fly
  rest    ///< the body came to rest, or was woken
};
inline constexpr std::array<std::string_view, 4> k_cause_names{"start", "hit", "mode", "rest"};

/// Value of `partner` if the segment's cause is not `hit`.
inline constexpr std::int32_t k_no_partner = -1;

struct Segment {
  std::uint32_t body = 0;  ///< a feature of the scene (common/scene), where bodies come first
  double start_s = 0;      ///< the segment is valid until the body's next one
  Mode mode = Mode::flying;
  Cause cause = Cause::start;
  std::int32_t partner = k_no_partner;  ///< feature that was hit, if the cause is `hit`
  math::Vec3 position_m{0, 0, 0};       ///< of the centre, at the start
  math::Vec3 velocity_mps{0, 0, 0};
  math::Vec3 acceleration_mps2{0, 0, 0};
  math::Quat orientation = math::Quat::Identity();  ///< from the body's frame to the scene's
  math::Vec3 angular_velocity_radps{0, 0, 0};
  math::Vec3 angular_acceleration_radps2{0, 0, 0};
};

/// Compares bit for bit.
bool operator==(const Segment& a, const Segment& b);

// REQUIRES for these functions: finite numbers, t_s >= start_s, a unit orientation.
math::Vec3 position_at(const Segment& segment, double t_s);
math::Vec3 velocity_at(const Segment& segment, double t_s);
/// If the axis turns too, orientation_at uses Magnus' expansion to the second term (Magnus 1954,
/// Communications on Pure and Applied Mathematics 7). The steps are short enough for 1e-6 rad, but
/// there are at most k_turn_steps_max.
math::Quat orientation_at(const Segment& segment, double t_s);
inline constexpr double k_turn_steps_max = 100'000;

/// Returns how far the centre's path deviates from the straight line between two of its points: |a|
/// d^2 / 8. In this formula, d is `duration_s`, the time between the two points.
double bow_m(const Segment& segment, double duration_s);

}  // namespace sleight::motion
