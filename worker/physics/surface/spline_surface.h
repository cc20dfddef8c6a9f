// A spline surface for simulations: computes heights, slopes, bounds, and contact laws at points.
// Patches are made when first accessed.
//
// Frame: the world's, z up. Patch (i, j) covers i spacing <= x < (i + 1) spacing, likewise in y.
// Patch (i, j) depends on the sixteen control points from (i - 1, j - 1) to (i + 2, j + 2).
//
// Formulas: the basis of the uniform cubic B-spline, as in Piegl and Tiller, "The NURBS Book" (2nd
// edition, 1997), chapter 2. Bounds come from the patch's Bezier points, because a Bezier spline
// stays between their minimum and maximum (ibid., P3.3 and P4.22).
//
// Invariants
//   1. Results depend only on the arguments and the control points, never on earlier calls.
//   2. Bounds hold everywhere in the region, rounding included.
// Thread safety: none, because queries make patches.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "worker/physics/surface/grid_table.h"
#include "worker/physics/surface/surface_controls.h"

namespace sleight::physics {

struct SurfacePlace {
  double height_m = 0;
  double slope_x = 0;  ///< dz/dx
  double slope_y = 0;
  double bend_xx_per_m = 0;  ///< second derivatives
  double bend_xy_per_m = 0;
  double bend_yy_per_m = 0;
};

struct SurfaceBounds {
  double top_m = 0;         ///< maximum height
  double slope = 0;         ///< of the steepest descent, >= 0
  double hollow_per_m = 0;  ///< greatest second derivative in any direction, >= 0
  double bump_per_m = 0;    ///< negated minimum second derivative, >= 0
  double twist_per_m2 = 0;  ///< greatest third derivative in any direction, >= 0
};

struct PatchRange {
  GridIndex low;
  GridIndex high;  ///< inclusive
  friend bool operator==(const PatchRange&, const PatchRange&) = default;
};

/// Maximum patch index on either axis: 2147 km at a spacing of 1 mm. For greater indices, those of
/// surrounding control points would overflow.
inline constexpr std::int32_t k_patch_index_max = INT32_MAX - 2;

/// REQUIRES: all points are finite and in patches up to k_patch_index_max.
class SplineSurface {
 public:
  /// Shares the control points. REQUIRES: controls is not null; spacing_m > 0.
  explicit SplineSurface(const StaticSurface& surface);

  double spacing_m() const { return spacing_m_; }
  SurfacePlace at(double x_m, double y_m);
  /// Bounds for the patches that a rectangle touches. REQUIRES: low <= high on each axis.
  SurfaceBounds bounds_in(double x_low_m, double x_high_m, double y_low_m, double y_high_m);
  /// Restitution and friction at a point; the height isn't set.
  SurfaceControl fields_at(double x_m, double y_m);
  /// A patch depends on sixteen control points. Returns their indices row by row; weights_at()
  /// returns their weights.
  static std::array<GridIndex, 16> support(GridIndex patch);
  GridIndex patch_at(double x_m, double y_m) const;
  std::array<double, 16> weights_at(double x_m, double y_m) const;
  std::size_t patches_made() const { return patches_.size(); }

 private:
  struct Patch {
    std::array<double, 16> coefficient{};  ///< of u^a v^b at index 4 a + b
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
