// A surface of control points as an archive holds them: those that an animation needs, and no more.
//
// Formula: a uniform bicubic B-spline, e.g. L. Piegl and W. Tiller, "The NURBS Book" (2nd edition,
// 1997), chapter 2. The patch (i, j) lies over i spacing <= x < (i + 1) spacing, likewise y, and
// hangs on the sixteen points from (i - 1, j - 1) to (i + 2, j + 2).
//
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace sleight::scene {

/// The values of the four basis functions at u, 0 to 1; they add up to 1.
std::array<double, 4> spline_weights(double u);

class Surface {
 public:
  /// REQUIRES: spacing_m > 0; points ascending by (j, i).
  Surface(std::span<const ControlPoint> points, double spacing_m);

  /// Nothing where a point of the patch is missing.
  std::optional<double> height_m(double x_m, double y_m) const;

  struct Patch {
    std::int32_t i = 0;
    std::int32_t j = 0;
  };
  /// All whose points are there, ascending by (j, i).
  const std::vector<Patch>& patches() const { return patches_; }
  double spacing_m() const { return spacing_m_; }

 private:
  const ControlPoint* find(std::int32_t i, std::int32_t j) const;

  std::vector<ControlPoint> points_;
  double spacing_m_;
  std::vector<Patch> patches_{};
};

/// As (i, j): the points of the patches that a square of half this side about each place touches,
/// ascending by (j, i), each once.
std::vector<std::array<std::int32_t, 2>> indices_about(std::span<const Vec3> places_m,
                                                       double half_m, double spacing_m);

}  // namespace sleight::scene
