// What a spline surface is made of: control points on a grid, each with a height and with how
// things bounce and slide there.
//
// The point (i, j) lies at x = i spacing, y = j spacing. A grid has no end: whoever gives the
// points says what lies beyond those that matter (a flat apron, say). They are asked for when
// something comes near, and only then.
// Thread safety: values; const functions may be called from several threads at once.
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sleight::physics {

/// A place in the grid of control points.
struct GridIndex {
  std::int32_t i = 0;
  std::int32_t j = 0;
  friend auto operator<=>(const GridIndex&, const GridIndex&) = default;
};

/// A control point. The fields at a place are averages of the sixteen points around it, so they
/// stay between the least and the greatest of these.
struct SurfaceControl {
  double height_m = 0;
  double restitution = 0;  ///< 0 to 1, of what meets the surface
  double friction = 0;     ///< Coulomb's coefficient, >= 0
  friend bool operator==(const SurfaceControl&, const SurfaceControl&) = default;
};

class SurfaceControls {
 public:
  virtual ~SurfaceControls() = default;
  /// A pure function of the index: finite, and within the ranges above.
  virtual SurfaceControl at(GridIndex index) const = 0;
  /// The points that may be others than `before` has: some too many do no harm but cost time.
  /// Nothing: any may.
  virtual std::optional<std::vector<GridIndex>> changed_from(
      const SurfaceControls& before) const = 0;
};

/// A surface z = S(x, y) that doesn't move, solid below: a uniform bicubic B-spline over control
/// points, and so are restitution and friction, which stand for those of any pair of materials.
struct StaticSurface {
  std::string name;
  std::shared_ptr<const SurfaceControls> controls;
  double spacing_m = 0;  ///< of the grid
  /// Bodies meet it with their corners and with points on their edges and faces that are no further
  /// apart than this. Between them a bump may pierce by curvature * (this)^2 / 4: some
  /// micrometres at 4 mm and 2 per metre.
  double point_spacing_m = 4e-3;
};

}  // namespace sleight::physics
