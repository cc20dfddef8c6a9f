// Converts a body's motion to keys between which players interpolate: straight lines for places,
// the shortest rotation for orientations (glTF's LINEAR).
//
// Between keys, the error is at most k_bow_m and k_turn_off_rad. The keys of a segment
// are equally spaced. Closed forms of both bounds give the spacing d without a search:
//
//   `place`: |a| d^2 / 8 for keys d apart, the sagitta of a parabola.
//   `turn`: phi(t), the rotation vector since a key, has |phi''| <= |a| (1 + |w| d) while phi is
//     small. A straight interpolation is off by |phi''| d^2 / 8.
//
// Consecutive keys differ by at most a rotation of k_turn_rad, so the shortest rotation is the
// right one. Some players interpolate the four numbers and normalise (Blender). Such players lag or
// lead by about turn^3 / 1000, which stays within k_turn_off_rad.
//
// Times are in single precision, and each key has the motion at its rounded time. So rounding only
// shifts events: at 10 m/s by at most 0.01 mm in the first 16 s, and 0.1 mm in the first 200 s.
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

// Three quarters of the promised bounds (0.1 mm, 0.2 degrees); the rest is for rounding. Bounds
// half as large would need 40% more keys.
inline constexpr double k_bow_m = 75e-6;
inline constexpr double k_turn_off_rad = 0.1 * 3.141592653589793 / 180;
inline constexpr double k_turn_rad = 40 * 3.141592653589793 / 180;

/// If a segment begins further than this from the end of the previous segment, the body jumps.
inline constexpr double k_jump_m = 10e-6;
inline constexpr double k_jump_rad = 0.02 * 3.141592653589793 / 180;

/// Maximum keys per body: a hundred times the keys of a die in a long throw.
inline constexpr std::uint64_t k_keys_max = 1'000'000;
inline constexpr double k_fps_max = 1000;

/// Times ascend strictly and are at least 0.
template <class Value>
struct Channel {
  std::vector<float> times_s{};
  std::vector<Value> values{};
};

struct BodyKeys {
  Channel<Float3> translation{};
  Channel<Float4> rotation{};  ///< neighbours are in the same hemisphere
  float enters_s = 0;          ///< time when the body appears
};

/// Returns keys from the body's entry until its last segment begins, or until `end_s` if the body
/// still moves then. Each segment's start has a key, or two keys one float apart if the body jumps
/// there. Motion before time 0 is omitted.
///
/// With `fps`, keys are only at whole multiples of 1 / fps: from the first multiple at which the
/// body exists to the first multiple after its motion.
///
/// Returns an error text if there are too many keys. REQUIRES: the body enters; fps in (0,
/// k_fps_max].
base::Result<BodyKeys, std::string> keys_of(const motion::Path& path, double end_s,
                                            std::optional<double> fps = std::nullopt);

}  // namespace sleight::gltf
