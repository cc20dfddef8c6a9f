// A body's motion as keys between which players interpolate: places along straight lines, turns the
// shortest way (glTF's LINEAR).
//
// What lies between keys is off by at most k_bow_m and k_turn_off_rad. Both come from closed forms,
// so keys of a segment are equally spaced and none is found by trying:
//
//   place   |a| d^2 / 8 of keys d apart, the sagitta of a parabola
//   turn    phi(t), the rotation vector since a key, has |phi''| <= |a| (1 + |w| d) while it is
//           small; straight in between it is off by |phi''| d^2 / 8
//
// Keys are also at most k_turn_rad of a turn apart. So "the shortest way" is the right one, and
// players that interpolate the four numbers and normalise (Blender), which lag behind or lead by
// some turn^3 / 1000, stay within the same tenth of a degree.
//
// Times are single-precision, and each key has what the motion is at its rounded time; so rounding
// costs what happens between an event and that: for 10 m/s, 0.01 mm up to 16 s and 0.1 mm up to 200
// s.
//
// Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/export/axes.h"
#include "common/base/result.h"
#include "common/motion/path.h"

namespace sleight::gltf {

// Three quarters of what is promised (0.1 mm, 0.2 degrees): the rest is for rounding. Half of them
// would make 40% more keys.
inline constexpr double k_bow_m = 75e-6;
inline constexpr double k_turn_off_rad = 0.1 * 3.141592653589793 / 180;
inline constexpr double k_turn_rad = 40 * 3.141592653589793 / 180;

/// A segment that begins further than this from where the one before ends is a jump.
inline constexpr double k_jump_m = 10e-6;
inline constexpr double k_jump_rad = 0.02 * 3.141592653589793 / 180;

/// Of one body: a hundred times what a die of a long throw has.
inline constexpr std::uint64_t k_keys_max = 1'000'000;
inline constexpr double k_fps_max = 1000;

/// Times ascend strictly and are not negative.
template <class Value>
struct Channel {
  std::vector<float> times_s{};
  std::vector<Value> values{};
};

struct BodyKeys {
  Channel<Float3> translation{};
  Channel<Float4> rotation{};  ///< neighbours lie on the same half of the sphere
  float enters_s = 0;          ///< when the body is there
};

/// Keys from when the body enters until its last segment begins or, if it still moves in that,
/// until `end_s`. At each segment's start is a key; where that is a jump, two keys, a float apart.
/// What happens before time 0 is left out.
///
/// With `fps`, keys at whole multiples of 1 / fps instead and nowhere else: from the first one when
/// the body is there to the first one when its motion has ended.
///
/// Says why there are none: too many. REQUIRES: it enters; fps in (0, k_fps_max].
base::Result<BodyKeys, std::string> keys_of(const motion::Path& path, double end_s,
                                            std::optional<double> fps = std::nullopt);

}  // namespace sleight::gltf
