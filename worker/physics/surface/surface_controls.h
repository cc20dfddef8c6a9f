// The control points of a spline surface, on a grid, each with a height, restitution and friction.
//
// Point (i, j) is at x = i spacing, y = j spacing. The grid is infinite: its provider also defines
// the points far from the relevant area, such as a flat apron. Control points are read only when a
// body comes near. Thread safety: values; const functions may run concurrently.
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sleight::physics {

struct GridIndex {
  std::int32_t i = 0;
  std::int32_t j = 0;
  friend auto operator<=>(const GridIndex&, const GridIndex&) = default;
};

/// A control point. Restitution and friction at a point of the surface are weighted averages of the
/// sixteen surrounding control points, so they stay between the minimum and maximum of these
/// points.
struct SurfaceControl {
  double height_m = 0;
  double restitution = 0;  ///< 0 to 1, for every body
  double friction = 0;     ///< Coulomb's coefficient, >= 0
  friend bool operator==(const SurfaceControl&, const SurfaceControl&) = default;
};

class SurfaceControls {
 public:
  virtual ~SurfaceControls() = default;
  /// Returns a point as a pure function of the index. REQUIRES of implementations: finite values
  /// within the ranges above.
  virtual SurfaceControl at(GridIndex index) const = 0;
  /// Returns the points that may differ from those of `before`; extra points do no harm but cost
  /// time. Returns nothing if any point may differ.
  virtual std::optional<std::vector<GridIndex>> changed_from(
      const SurfaceControls& before) const = 0;
};

/// A fixed surface z = S(x, y), solid below: a uniform bicubic B-spline over control points.
/// Restitution and friction are splines too, and replace the laws of material pairs.
struct StaticSurface {
  std::string name;
  std::shared_ptr<const SurfaceControls> controls;
  double spacing_m = 0;  ///< of the grid
  /// Maximum distance between the points of a body that can touch the surface: its corners, and
  /// points on its edges and faces. Between neighbouring points a bump may penetrate by curvature *
  /// point_spacing_m^2 / 4: some micrometres at 4 mm and 2 per metre.
  double point_spacing_m = 4e-3;
};

}  // namespace sleight::physics
