// A spline surface as simulations ask for it: heights, slopes, bounds and laws at places, from
// patches that are made when somebody first comes near.
//
// Frame: the world's, z up. The patch (i, j) lies over i spacing <= x < (i + 1) spacing, likewise
// y, and hangs on the sixteen control points from (i - 1, j - 1) to (i + 2, j + 2).
//
// Formulas: the uniform cubic B-spline's basis, e.g. L. Piegl and W. Tiller, "The NURBS Book"
// (2nd edition, 1997), chapter 2; bounds are those of the same patch's Bezier form, since a Bezier
// spline stays between the least and greatest of its points (ibid., P3.3 and P4.22).
//
// Invariants
//   1. Results are functions of the arguments and the control points, never of earlier calls.
//   2. Bounds hold at every place of the region, rounding included.
// Thread safety: none: asking makes patches.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "worker/physics/surface/grid_table.h"
#include "worker/physics/surface/surface_controls.h"

namespace sleight::physics {

/// A place on the surface, and how it rises there.
struct SurfacePlace {
  double height_m = 0;
  double slope_x = 0;  ///< dz/dx
  double slope_y = 0;
  double bend_xx_per_m = 0;  ///< second derivatives
  double bend_xy_per_m = 0;
  double bend_yy_per_m = 0;
};

/// What the surface does at most in a region.
struct SurfaceBounds {
  double top_m = 0;         ///< no height is above
  double slope = 0;         ///< of the steepest descent, >= 0
  double hollow_per_m = 0;  ///< greatest second derivative in any direction, >= 0
  double bump_per_m = 0;    ///< least one, with its sign changed, >= 0
  double twist_per_m2 = 0;  ///< greatest third derivative in any direction, >= 0
};

struct PatchRange {
  GridIndex low;
  GridIndex high;  ///< inclusive
  friend bool operator==(const PatchRange&, const PatchRange&) = default;
};

/// Patches lie at most so many from the origin on either axis, so that the indices of the points
/// around them fit: at 1 mm, 2147 km.
inline constexpr std::int32_t k_patch_index_max = INT32_MAX - 2;

/// REQUIRES for all places: finite, and in such a patch.
class SplineSurface {
 public:
  /// Shares the control points. REQUIRES: there are some; spacing_m > 0.
  explicit SplineSurface(const StaticSurface& surface);

  double spacing_m() const { return spacing_m_; }
  SurfacePlace at(double x_m, double y_m);
  /// Of the patches that a rectangle touches. REQUIRES: low <= high on each axis.
  SurfaceBounds bounds_in(double x_low_m, double x_high_m, double y_low_m, double y_high_m);
  /// Its heights do not enter.
  SurfaceControl fields_at(double x_m, double y_m);
  /// The sixteen control points that a place hangs on, row by row, and their weights there.
  static std::array<GridIndex, 16> support(GridIndex patch);
  GridIndex patch_at(double x_m, double y_m) const;
  std::array<double, 16> weights_at(double x_m, double y_m) const;
  std::size_t patches_made() const { return patches_.size(); }

 private:
  struct Patch {
    std::array<double, 16> coefficient{};  ///< of u^a v^b at 4 a + b
    SurfaceBounds bounds;
  };
  const Patch& patch(GridIndex index);
  Patch made(GridIndex index);
  const SurfaceControl& control(GridIndex index);

  std::shared_ptr<const SurfaceControls> controls_;
  double spacing_m_;
  double per_spacing_;
  GridTable<SurfaceControl> points_;
  GridTable<Patch> patches_;
  PatchRange last_range_;
  SurfaceBounds last_bounds_;
  bool has_last_range_ = false;
};

}  // namespace sleight::physics
