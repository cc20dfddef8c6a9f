// Reference for spline surfaces: computes the definition, a sum of control points times basis
// functions, in long double. The recursion of Cox and de Boor computes the basis functions. The
// reference uses no powers of a place in a cell. The reference sums eight times eight points,
// although most of their basis functions are zero.
//
// Formulas: Piegl and Tiller, "The NURBS Book" (2nd edition, 1997), equations 2.5 and 2.7, with a
// knot at every integer. In the book's notation, N_{i-2,3} is the basis function that is greatest
// at the knot i.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/random/stream.h"
#include "worker/physics/surface/spline_surface.h"

namespace sleight::physics::testing {

using Long = long double;

/// Half the distance from 1 to the next double: the greatest relative error of one operation.
inline constexpr double k_unit = 0x1p-53;

/// Control points from a function. Counts the calls.
class FunctionControls final : public SurfaceControls {
 public:
  using Function = std::function<SurfaceControl(GridIndex)>;
  explicit FunctionControls(Function function) : function_(std::move(function)) {}
  SurfaceControl at(GridIndex index) const override {
    ++calls_;
    return function_(index);
  }
  std::optional<std::vector<GridIndex>> changed_from(const SurfaceControls&) const override {
    return std::nullopt;
  }
  std::uint64_t calls() const { return calls_; }

 private:
  Function function_;
  mutable std::uint64_t calls_ = 0;
};

inline std::shared_ptr<FunctionControls> controls_of(FunctionControls::Function function) {
  return std::make_shared<FunctionControls>(std::move(function));
}

/// Control points whose heights are a function of the index. Their other fields don't matter.
inline std::shared_ptr<FunctionControls> heights_of(std::function<double(double, double)> height) {
  return controls_of([height = std::move(height)](GridIndex index) {
    return SurfaceControl{.height_m = height(index.i, index.j), .restitution = 0.5};
  });
}

/// Infinitely many independent points. Heights are within +-height_m, restitution is up to 1, and
/// friction is up to 2.
inline std::shared_ptr<FunctionControls> random_controls(std::uint64_t seed, double height_m) {
  return controls_of([seed, height_m](GridIndex index) {
    const auto i = static_cast<std::uint64_t>(static_cast<std::uint32_t>(index.i));
    const auto j = static_cast<std::uint64_t>(static_cast<std::uint32_t>(index.j));
    random::Stream stream({.seed = seed, .purpose = random::Purpose::scene}, i << 32U | j);
    const double height = height_m * (2 * stream.uniform() - 1);
    const double restitution = stream.uniform();
    return SurfaceControl{
        .height_m = height, .restitution = restitution, .friction = 2 * stream.uniform()};
  });
}

inline StaticSurface surface_of(std::shared_ptr<const SurfaceControls> controls, double spacing_m) {
  return {.name = "sheet", .controls = std::move(controls), .spacing_m = spacing_m};
}

/// N_{k,degree} or a derivative. Both factors of a derivative are 1, because knots are 1 apart.
inline Long basis_function(std::int64_t k, int degree, Long t, int derivative) {
  const Long from_knot = t - static_cast<Long>(k);
  if (derivative > 0)
    return basis_function(k, degree - 1, t, derivative - 1) -
           basis_function(k + 1, degree - 1, t, derivative - 1);
  if (degree == 0) return from_knot >= 0 && from_knot < 1 ? 1 : 0;
  const Long to_last = static_cast<Long>(degree + 1) - from_knot;
  return from_knot / static_cast<Long>(degree) * basis_function(k, degree - 1, t, 0) +
         to_last / static_cast<Long>(degree) * basis_function(k + 1, degree - 1, t, 0);
}

struct ReferencePlace {
  Long height = 0;
  Long slope_x = 0;
  Long slope_y = 0;
  Long xx = 0;
  Long xy = 0;
  Long yy = 0;
  Long restitution = 0;
  Long friction = 0;

  Long slope() const { return std::sqrt(slope_x * slope_x + slope_y * slope_y); }
  /// Greatest and least eigenvalue of the matrix of second derivatives.
  Long second_most() const { return (xx + yy) / 2 + half_gap(); }
  Long second_least() const { return (xx + yy) / 2 - half_gap(); }

 private:
  Long half_gap() const { return std::sqrt((xx - yy) * (xx - yy) / 4 + xy * xy); }
};

/// Basis functions of eight points around a place on an axis: values, first and second derivatives.
struct ReferenceAxis {
  explicit ReferenceAxis(Long t) : first(static_cast<std::int64_t>(std::floor(t)) - 3) {
    for (std::size_t n = 0; n < 8; ++n) {
      for (int derivative = 0; derivative < 3; ++derivative)
        of[static_cast<std::size_t>(derivative)][n] =
            basis_function(first + static_cast<std::int64_t>(n) - 2, 3, t, derivative);
    }
  }
  std::int64_t first;
  std::array<std::array<Long, 8>, 3> of{};
};

inline ReferencePlace reference_at(const StaticSurface& surface, Long x_m, Long y_m) {
  const Long spacing = surface.spacing_m;
  const ReferenceAxis x(x_m / spacing);
  const ReferenceAxis y(y_m / spacing);
  ReferencePlace sum;
  for (std::size_t a = 0; a < 8; ++a) {
    for (std::size_t b = 0; b < 8; ++b) {
      const SurfaceControl one =
          surface.controls->at({static_cast<std::int32_t>(x.first + static_cast<std::int64_t>(a)),
                                static_cast<std::int32_t>(y.first + static_cast<std::int64_t>(b))});
      const Long height = one.height_m;
      sum.height += x.of[0][a] * y.of[0][b] * height;
      sum.slope_x += x.of[1][a] * y.of[0][b] * height / spacing;
      sum.slope_y += x.of[0][a] * y.of[1][b] * height / spacing;
      sum.xx += x.of[2][a] * y.of[0][b] * height / (spacing * spacing);
      sum.xy += x.of[1][a] * y.of[1][b] * height / (spacing * spacing);
      sum.yy += x.of[0][a] * y.of[2][b] * height / (spacing * spacing);
      sum.restitution += x.of[0][a] * y.of[0][b] * static_cast<Long>(one.restitution);
      sum.friction += x.of[0][a] * y.of[0][b] * static_cast<Long>(one.friction);
    }
  }
  return sum;
}

/// Bound on the error of a height, for heights within +-height_m. Includes the rounding of the sums
/// and of the place in the grid. The place's rounding grows with the index. The slope multiplies
/// this rounding; it is up to 2 height_m per cell and axis.
inline double height_error_m(const StaticSurface& surface, double height_m, double x_m,
                             double y_m) {
  const double cells = (std::fabs(x_m) + std::fabs(y_m)) / surface.spacing_m;
  return k_unit * height_m * (16 + 4 * cells);
}
/// Bound on the error of a slope. Assumes that second differences are at most 4 height_m.
inline double slope_error(const StaticSurface& surface, double height_m, double x_m, double y_m) {
  const double cells = (std::fabs(x_m) + std::fabs(y_m)) / surface.spacing_m;
  return k_unit * height_m * (40 + 8 * cells) / surface.spacing_m;
}

}  // namespace sleight::physics::testing
