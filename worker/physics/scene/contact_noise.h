// Noise of impacts: every impact fast enough has a slightly other normal and restitution.
//
// The noise makes a scene uncertain at each impact, as surfaces are that are not quite smooth. A
// noised impact has an address: its pair and its number among the pair's noised impacts. Three
// standard normals belong to each address. So if one value changes, the simulation up to that
// impact stays the same, bit for bit, and a replay takes it over (reuse/replay.h).
//
// An impact that approaches at the speed u has the strength s = (u - above) / above, at most 1. If
// s <= 0, the impact has no noise and no number. Otherwise, with values x1, x2 and x3, it is
// resolved along the normal n + s tilt_sd (x1 t1 + x2 t2), normalised, with two unit tangents t1
// and t2 that depend only on n, and with the restitution e + s restitution_sd x3, clamped to
// [0, 1]. If the contact still approaches along n afterwards, a second impact along n without
// restitution follows. Neither gains energy. A body that is caught or settles at an impact has no
// noise there; lasting contact has none either.
//
// Thread safety: values; const functions of NoiseValues may run concurrently.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <memory>

namespace sleight::physics {

/// Identifies a noised impact.
struct NoiseAddress {
  std::uint32_t lower = 0;   ///< id of the first body
  std::uint32_t higher = 0;  ///< as Impact::higher
  std::uint32_t number = 0;  ///< 1, 2, ... among the pair's noised impacts
  friend auto operator<=>(const NoiseAddress&, const NoiseAddress&) = default;
};

/// Two for the tilt of the normal, one for the restitution.
using NoiseValue = std::array<double, 3>;

class NoiseValues {
 public:
  virtual ~NoiseValues() = default;
  /// Returns the same finite value whenever it is called with the same address.
  virtual NoiseValue at(const NoiseAddress& address) const = 0;
};

struct ContactNoise {
  double above_mps = 0;  ///< > 0 if there is noise
  double tilt_sd_rad = 0;
  double restitution_sd = 0;
  std::shared_ptr<const NoiseValues> values;  ///< null: no noise

  bool is_on() const { return values != nullptr; }
  double strength(double approach_mps) const {
    return std::clamp((approach_mps - above_mps) / above_mps, 0.0, 1.0);
  }
};

}  // namespace sleight::physics
