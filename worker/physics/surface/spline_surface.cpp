#include "worker/physics/surface/spline_surface.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace sleight::physics {
namespace {

/// Memory is reserved for this many points and patches: about the number near a typical throw.
constexpr std::size_t k_points = 256;
constexpr std::size_t k_patches = 128;
/// Bounds are widened by this share, because differences and evaluation are rounded.
constexpr double k_bound_margin = 1e-9;
/// Bounds are also widened by this share of the heights, because differences of heights may cancel.
constexpr double k_height_rounding = 64 * 0x1p-53;

using Points = std::array<std::array<double, 4>, 4>;  ///< by i, then by j

/// Returns the index of the cell that contains a coordinate; the coordinate's unit is a cell.
/// Equals std::floor without a function call. Converting a number that doesn't fit an integer would
/// be undefined behaviour.
std::int32_t index_of(double place) {
  constexpr double k_most = k_patch_index_max;
  CHECK(place >= -k_most && place < k_most + 1);
  const auto index = static_cast<std::int32_t>(place);
  return index - (static_cast<double>(index) > place ? 1 : 0);
}

/// Returns the coefficients of 1, u, u^2 and u^3 in the B-spline cubic over four points.
std::array<double, 4> cubic_over(double p0, double p1, double p2, double p3) {
  constexpr double k_sixth = 1.0 / 6.0;
  return {((p0 + p2) + 4 * p1) * k_sixth, 0.5 * (p2 - p0), 0.5 * ((p0 + p2) - 2 * p1),
          ((p3 - p0) + 3 * (p1 - p2)) * k_sixth};
}

/// The four basis functions at a coordinate in a cell.
std::array<double, 4> basis_at(double u) {
  constexpr double k_sixth = 1.0 / 6.0;
  const double w = 1 - u;
  const double u2 = u * u;
  return {k_sixth * (w * w * w), k_sixth * ((3 * u - 6) * u2 + 4),
          k_sixth * (((-3 * u + 3) * u + 3) * u + 1), k_sixth * (u2 * u)};
}

struct Extent {
  double least = 0;
  double most = 0;
  void hold(double value, bool first) {
    least = first ? value : std::min(least, value);
    most = first ? value : std::max(most, value);
  }
  double magnitude() const { return std::max(std::fabs(least), std::fabs(most)); }
};

/// Bezier points of the B-spline cubic over four points.
std::array<double, 4> bezier_points(double p0, double p1, double p2, double p3) {
  constexpr double k_third = 1.0 / 3.0;
  constexpr double k_sixth = 1.0 / 6.0;
  return {((p0 + p2) + 4 * p1) * k_sixth, (2 * p1 + p2) * k_third, (p1 + 2 * p2) * k_third,
          ((p1 + p3) + 4 * p2) * k_sixth};
}

/// Returns a patch's Bezier points, which are nearer to the patch than the B-spline's points.
Points bezier_points(const Points& p) {
  Points in_v;
  for (std::size_t a = 0; a < 4; ++a)
    in_v[a] = bezier_points(p[a][0], p[a][1], p[a][2], p[a][3]);
  Points q;
  for (std::size_t b = 0; b < 4; ++b) {
    const std::array<double, 4> in_u =
        bezier_points(in_v[0][b], in_v[1][b], in_v[2][b], in_v[3][b]);
    for (std::size_t a = 0; a < 4; ++a)
      q[a][b] = in_u[a];
  }
  return q;
}

/// Returns an upper bound for a Bezier patch's third derivative in any direction. The unit of
/// length is a cell.
double third_differences(const Points& p) {
  double xxx = 0;
  double xxy = 0;
  double xyy = 0;
  double yyy = 0;
  const auto along_x = [&](std::size_t a, std::size_t b) { return p[a + 1][b] - p[a][b]; };
  const auto along_y = [&](std::size_t a, std::size_t b) { return p[a][b + 1] - p[a][b]; };
  const auto bend_x = [&](std::size_t a, std::size_t b) {
    return along_x(a + 1, b) - along_x(a, b);
  };
  const auto bend_y = [&](std::size_t a, std::size_t b) {
    return along_y(a, b + 1) - along_y(a, b);
  };
  for (std::size_t k = 0; k < 4; ++k) {
    xxx = std::max(xxx, std::fabs(bend_x(1, k) - bend_x(0, k)));
    yyy = std::max(yyy, std::fabs(bend_y(k, 1) - bend_y(k, 0)));
  }
  for (std::size_t a = 0; a < 2; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      xxy = std::max(xxy, std::fabs(bend_x(a, b + 1) - bend_x(a, b)));
      xyy = std::max(xyy, std::fabs(bend_y(b + 1, a) - bend_y(b, a)));
    }
  }
  // The derivative in direction (c, s) is c^3 S_xxx + 3 c^2 s S_xxy + ..., where c^2 s <= 2 /
  // sqrt(27).
  constexpr double k_mixed = 3 * 0.3849002;
  return 6 * (xxx + yyy) + k_mixed * 18 * (xxy + xyy);
}

/// Bounds of a Bezier patch. The patch and its derivatives stay between the minimum and maximum of
/// their Bezier points. A derivative's Bezier points are differences of the patch's points: 3 times
/// the first differences, 6 times the second ones, or 9 times the mixed ones.
SurfaceBounds bounds_over(const Points& p, double per_spacing) {
  Extent height;
  Extent x;
  Extent y;
  Extent xx;
  Extent yy;
  Extent xy;
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = 0; b < 4; ++b) {
      height.hold(p[a][b], a + b == 0);
      if (a < 3) x.hold(p[a + 1][b] - p[a][b], a + b == 0);
      if (b < 3) y.hold(p[a][b + 1] - p[a][b], a + b == 0);
      if (a < 2) xx.hold((p[a][b] + p[a + 2][b]) - 2 * p[a + 1][b], a + b == 0);
      if (b < 2) yy.hold((p[a][b] + p[a][b + 2]) - 2 * p[a][b + 1], a + b == 0);
      if (a < 3 && b < 3)
        xy.hold((p[a + 1][b + 1] + p[a][b]) - (p[a + 1][b] + p[a][b + 1]), a + b == 0);
    }
  }
  const double rounding_m = k_height_rounding * height.magnitude();
  const double twist_m = third_differences(p) + 8 * 32 * rounding_m;
  const double wider = 1 + k_bound_margin;
  const double per_area = per_spacing * per_spacing;
  const double slope_x = 3 * (x.magnitude() + rounding_m) * per_spacing;
  const double slope_y = 3 * (y.magnitude() + rounding_m) * per_spacing;
  // Each eigenvalue of a symmetric matrix is inside the disc of one of its rows (Gershgorin).
  const double turn_m = 9 * (xy.magnitude() + rounding_m);
  const double most_m = 6 * (std::max(xx.most, yy.most) + rounding_m) + turn_m;
  const double least_m = 6 * (std::min(xx.least, yy.least) - rounding_m) - turn_m;
  return {.top_m = height.most + rounding_m,
          .slope = wider * std::sqrt(slope_x * slope_x + slope_y * slope_y),
          .hollow_per_m = wider * std::max(0.0, most_m * per_area),
          .bump_per_m = wider * std::max(0.0, -least_m * per_area),
          .twist_per_m2 = wider * twist_m * per_area * per_spacing};
}

}  // namespace

SplineSurface::SplineSurface(const StaticSurface& surface)
    : controls_(surface.controls),
      spacing_m_(surface.spacing_m),
      per_spacing_(1 / surface.spacing_m),
      points_(k_points),
      patches_(k_patches) {
  CHECK(controls_ != nullptr);
  CHECK(spacing_m_ > 0);
}

GridIndex SplineSurface::patch_at(double x_m, double y_m) const {
  return {index_of(x_m * per_spacing_), index_of(y_m * per_spacing_)};
}

SurfacePlace SplineSurface::at(double x_m, double y_m) {
  const double column = x_m * per_spacing_;
  const double row = y_m * per_spacing_;
  const GridIndex index{index_of(column), index_of(row)};
  const double u = column - index.i;
  const double v = row - index.j;
  const Patch& here = patch(index);
  const std::array<double, 16>& c = here.coefficient;
  std::array<double, 4> value;  // of each power of u
  std::array<double, 4> along_v;
  std::array<double, 4> bend_v;
  for (std::size_t a = 0; a < 4; ++a) {
    const std::size_t k = 4 * a;
    value[a] = ((c[k + 3] * v + c[k + 2]) * v + c[k + 1]) * v + c[k];
    along_v[a] = (3 * c[k + 3] * v + 2 * c[k + 2]) * v + c[k + 1];
    bend_v[a] = 6 * c[k + 3] * v + 2 * c[k + 2];
  }
  const double per_area = per_spacing_ * per_spacing_;
  return {
      .height_m = ((value[3] * u + value[2]) * u + value[1]) * u + value[0],
      .slope_x = ((3 * value[3] * u + 2 * value[2]) * u + value[1]) * per_spacing_,
      .slope_y = (((along_v[3] * u + along_v[2]) * u + along_v[1]) * u + along_v[0]) * per_spacing_,
      .bend_xx_per_m = (6 * value[3] * u + 2 * value[2]) * per_area,
      .bend_xy_per_m = ((3 * along_v[3] * u + 2 * along_v[2]) * u + along_v[1]) * per_area,
      .bend_yy_per_m = (((bend_v[3] * u + bend_v[2]) * u + bend_v[1]) * u + bend_v[0]) * per_area};
}

SurfaceBounds SplineSurface::bounds_in(double x_low_m, double x_high_m, double y_low_m,
                                       double y_high_m) {
  const PatchRange range{patch_at(x_low_m, y_low_m), patch_at(x_high_m, y_high_m)};
  if (has_last_range_ && range == last_range_) return last_bounds_;
  CHECK(range.low.i <= range.high.i && range.low.j <= range.high.j);
  SurfaceBounds all = patch(range.low).bounds;
  for (std::int32_t i = range.low.i; i <= range.high.i; ++i) {
    for (std::int32_t j = range.low.j; j <= range.high.j; ++j) {
      const SurfaceBounds& one = patch({i, j}).bounds;
      all.top_m = std::max(all.top_m, one.top_m);
      all.slope = std::max(all.slope, one.slope);
      all.hollow_per_m = std::max(all.hollow_per_m, one.hollow_per_m);
      all.bump_per_m = std::max(all.bump_per_m, one.bump_per_m);
      all.twist_per_m2 = std::max(all.twist_per_m2, one.twist_per_m2);
    }
  }
  last_range_ = range;
  last_bounds_ = all;
  has_last_range_ = true;
  return all;
}

std::array<GridIndex, 16> SplineSurface::support(GridIndex patch) {
  std::array<GridIndex, 16> points;
  for (std::int32_t a = 0; a < 4; ++a) {
    for (std::int32_t b = 0; b < 4; ++b)
      points[static_cast<std::size_t>(4 * a + b)] = {patch.i + (a - 1), patch.j + (b - 1)};
  }
  return points;
}

std::array<double, 16> SplineSurface::weights_at(double x_m, double y_m) const {
  const double column = x_m * per_spacing_;
  const double row = y_m * per_spacing_;
  const std::array<double, 4> of_u = basis_at(column - index_of(column));
  const std::array<double, 4> of_v = basis_at(row - index_of(row));
  std::array<double, 16> weights;
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = 0; b < 4; ++b)
      weights[4 * a + b] = of_u[a] * of_v[b];
  }
  return weights;
}

SurfaceControl SplineSurface::fields_at(double x_m, double y_m) {
  const std::array<GridIndex, 16> points = support(patch_at(x_m, y_m));
  const std::array<double, 16> weights = weights_at(x_m, y_m);
  SurfaceControl sum;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const SurfaceControl& one = control(points[k]);
    sum.restitution += weights[k] * one.restitution;
    sum.friction += weights[k] * one.friction;
  }
  // The weights sum to 1 except for rounding.
  sum.restitution = std::clamp(sum.restitution, 0.0, 1.0);
  sum.friction = std::max(sum.friction, 0.0);
  return sum;
}

SplineSurface::Patch SplineSurface::made(GridIndex index) {
  Points p;
  const std::array<GridIndex, 16> points = support(index);
  for (std::size_t k = 0; k < points.size(); ++k)
    p[k / 4][k % 4] = control(points[k]).height_m;
  Patch patch;
  std::array<std::array<double, 4>, 4> in_v;  // by i: coefficients of powers of v
  for (std::size_t a = 0; a < 4; ++a)
    in_v[a] = cubic_over(p[a][0], p[a][1], p[a][2], p[a][3]);
  for (std::size_t b = 0; b < 4; ++b) {
    const std::array<double, 4> in_u = cubic_over(in_v[0][b], in_v[1][b], in_v[2][b], in_v[3][b]);
    for (std::size_t a = 0; a < 4; ++a)
      patch.coefficient[4 * a + b] = in_u[a];
  }
  patch.bounds = bounds_over(bezier_points(p), per_spacing_);
  return patch;
}

const SplineSurface::Patch& SplineSurface::patch(GridIndex index) {
  return patches_.at(index, [&](GridIndex where) { return made(where); });
}

const SurfaceControl& SplineSurface::control(GridIndex index) {
  return points_.at(index, [&](GridIndex where) { return controls_->at(where); });
}

}  // namespace sleight::physics
