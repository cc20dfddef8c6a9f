// A piece of a body's recorded motion, as archives hold it: a closed function of time.
//
// Every world's recordings are such pieces, so that whoever shows, searches or exports an animation
// needs neither the world's code nor a simulator.
//
//   centre       c(t) = position + velocity s + acceleration s^2 / 2       s = t - start
//   orientation  turned by the angular velocity w(t) = w + a s, in the scene's frame
//
// A body of which the simulator knows more than that (one that tumbles with unequal moments of
// inertia) has segments as short as that takes.
//
// Units are SI, times count from the animation's beginning; the scene's frame is right-handed with
// z up (common/scene). Thread safety: values and pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "common/math/rotation.h"
#include "common/math/vector.h"

namespace sleight::motion {

/// How the body moves. In the order of k_mode_names.
enum class Mode : std::uint8_t {
  flying,   ///< gravity alone acts
  sliding,  ///< on something that doesn't move, and its surface slips
  rolling,  ///< the same without slip
  resting   ///< it doesn't move
};
inline constexpr std::array<std::string_view, 4> k_mode_names{"flying", "sliding", "rolling",
                                                              "resting"};

/// What began the segment. In the order of k_cause_names.
enum class Cause : std::uint8_t {
  start,  ///< the body enters
  hit,    ///< it met the partner
  mode,   ///< it begins to slide, roll or fly
  rest    ///< it has come to rest, or was woken
};
inline constexpr std::array<std::string_view, 4> k_cause_names{"start", "hit", "mode", "rest"};

/// Of a segment that no other thing began.
inline constexpr std::int32_t k_no_partner = -1;

struct Segment {
  std::uint32_t body = 0;  ///< a feature of the scene (common/scene): bodies come first
  double start_s = 0;      ///< it holds until the body's next one
  Mode mode = Mode::flying;
  Cause cause = Cause::start;
  std::int32_t partner = k_no_partner;  ///< the feature that was hit, of cause `hit`
  math::Vec3 position_m{0, 0, 0};       ///< of the centre, at the start
  math::Vec3 velocity_mps{0, 0, 0};
  math::Vec3 acceleration_mps2{0, 0, 0};
  math::Quat orientation = math::Quat::Identity();  ///< from the body's frame to the scene's
  math::Vec3 angular_velocity_radps{0, 0, 0};
  math::Vec3 angular_acceleration_radps2{0, 0, 0};
};

/// Bit for bit.
bool operator==(const Segment& a, const Segment& b);

// REQUIRES of the following: finite numbers, t_s >= start_s, a unit orientation.
math::Vec3 position_at(const Segment& segment, double t_s);
math::Vec3 velocity_at(const Segment& segment, double t_s);
/// Where the axis turns too, by Magnus' expansion to its second term (W. Magnus, Comm. Pure Appl.
/// Math. 7, 1954) in steps that are short enough for 1e-6 rad; at most k_turn_steps_max of them.
math::Quat orientation_at(const Segment& segment, double t_s);
inline constexpr double k_turn_steps_max = 100'000;

/// How far the centre of the segment strays from the straight line between two of its moments, at
/// most: |a| d^2 / 8 of moments d apart.
double bow_m(const Segment& segment, double duration_s);

}  // namespace sleight::motion
