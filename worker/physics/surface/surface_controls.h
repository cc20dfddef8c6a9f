// A spline surface's control points form a grid. Each point has a height, restitution and friction.
//
// Point (i, j) is at x = i spacing, y = j spacing. The grid is infinite: its provider also defines
// points far away, for instance as a flat apron. Control points are read only when a body comes
// near. Thread safety: values; const functions may run concurrently.
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "worker/physics/event/ids.h"

namespace sleight::physics {

struct GridIndex {
  std::int32_t i = 0;
  std::int32_t j = 0;
  friend auto operator<=>(const GridIndex&, const GridIndex&) = default;
};

/// A control point. At a point of the surface, restitution and friction are weighted averages over
/// the sixteen surrounding control points. So restitution and friction stay between these points'
/// minimum and maximum.
struct SurfaceControl {
  double height_m = 0;
  double restitution = 0;  ///< 0 to 1, for every body
  double friction = 0;     ///< Coulomb's coefficient, >= 0
  friend bool operator==(const SurfaceControl&, const SurfaceControl&) = default;
};

class SurfaceControls {
 public:
  virtual ~SurfaceControls() = default;
  /// Returns the control point at an index. The result depends only on the index. Implementations
  /// must return finite values within the ranges above.
  virtual SurfaceControl at(GridIndex index) const = 0;
  /// Returns the points that may differ from those of `before`. Too many points do no harm but cost
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
  /// Only some points of a body can touch the surface: its corners, and points on its edges and
  /// faces. `point_spacing_m` is the maximum distance between neighbouring points. Between them a
  /// bump may penetrate by curvature * point_spacing_m^2 / 4: some micrometres at 4 mm and 2 per
  /// metre.
  double point_spacing_m = 4e-3;
  CollisionGroup group{};
};

}  // namespace sleight::physics
