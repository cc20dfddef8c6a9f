// A surface from control points. An archive stores only the points that an animation needs.
//
// Formula: a uniform bicubic B-spline, see Piegl and Tiller, "The NURBS Book" (2nd edition, 1997),
// chapter 2. Patch (i, j) covers i spacing <= x < (i + 1) spacing and j spacing <= y < (j + 1)
// spacing. The patch depends on the sixteen points from (i - 1, j - 1) to (i + 2, j + 2).
//
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace sleight::scene {

/// Returns the values of the four basis functions at u. The values add up to 1. REQUIRES: u is from
/// 0 to 1.
std::array<double, 4> spline_weights(double u);

class Surface {
 public:
  /// REQUIRES: spacing_m > 0; points sorted by (j, i).
  Surface(std::span<const ControlPoint> points, double spacing_m);

  /// Returns nothing if a point of the patch is missing.
  std::optional<double> height_m(double x_m, double y_m) const;

  struct Patch {
    std::int32_t i = 0;
    std::int32_t j = 0;
  };
  /// Returns the patches that have all their points. Sorted by (j, i).
  const std::vector<Patch>& patches() const { return patches_; }
  double spacing_m() const { return spacing_m_; }

 private:
  const ControlPoint* find(std::int32_t i, std::int32_t j) const;

  std::vector<ControlPoint> points_;
  double spacing_m_;
  std::vector<Patch> patches_{};
};

/// Around each place, imagine a square with sides 2 half_m. Returns the points (i, j) of all
/// patches that such a square touches, each point once. Sorted by (j, i).
std::vector<std::array<std::int32_t, 2>> indices_about(std::span<const Vec3> places_m,
                                                       double half_m, double spacing_m);

}  // namespace sleight::scene
