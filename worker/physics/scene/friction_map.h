// Friction that varies across a plane, such as on an oiled bowling lane. Rectangles define it.
//
// The coordinates u and v are along two axes of the plane. A rectangle contains the points with
// u_min <= u < u_max and v_min <= v < v_max. If rectangles overlap, the later one applies, as if
// painted over the earlier one. Outside all rectangles, the scene's contact table gives the
// friction.
//
// Idea. A body that slides or rolls on one plane moves along a parabola as long as its friction
// stays constant. The parabola crosses the sides of a rectangle at roots of quadratic equations. A
// tree of boxes finds the rectangles that the path may enter before it leaves its current
// rectangle.
//
// Invariant: from a path's start, one rectangle applies for the time border_s, except for rounding.
// Thread safety: const functions may run concurrently.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "worker/physics/motion/rigid_body.h"
#include "worker/physics/scene/box_tree.h"

namespace sleight::physics {

struct FrictionRectangle {
  double u_min_m = 0;
  double u_max_m = 0;  ///< > u_min_m
  double v_min_m = 0;
  double v_max_m = 0;   ///< > v_min_m
  double friction = 0;  ///< Coulomb's mu, 0 to 1e6, for any body touching the plane here
  bool operator==(const FrictionRectangle&) const = default;
};

/// The axes of a map. A point's coordinates are u.(point - origin) and v.(point - origin).
struct MapFrame {
  Vec3 origin_m = Vec3::Zero();
  Vec3 u = Vec3::UnitX();  ///< unit vectors, perpendicular to each other and the plane's normal
  Vec3 v = Vec3::UnitY();
};

struct MapPath {
  Vec3 place_m = Vec3::Zero();
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 acceleration_mps2 = Vec3::Zero();
};

class FrictionMap {
 public:
  static constexpr std::size_t k_rectangles_max = 4096;

  /// Returns an error message that names the invalid rectangle or axis.
  static base::Result<FrictionMap, std::string> make(const MapFrame& frame,
                                                     std::vector<FrictionRectangle> rectangles);

  /// Returns nothing if no rectangle contains the point.
  std::optional<double> friction_at(const Vec3& point_m) const;
  /// Returns the time until the applicable rectangle changes, but at most most_s.
  double border_s(const MapPath& path, double most_s) const;

  const MapFrame& frame() const { return frame_; }
  bool same_as(const FrictionMap& other) const;

 private:
  struct Plane2 {
    double u = 0;
    double v = 0;
  };
  FrictionMap(const MapFrame& frame, std::vector<FrictionRectangle> rectangles);
  Plane2 coordinates(const Vec3& vector) const;
  /// Returns 1 plus the index of the last rectangle that contains a point; 0 if none does.
  std::size_t count_at(const Plane2& place) const;

  MapFrame frame_;
  std::vector<FrictionRectangle> rectangles_;
  BoxTree tree_;
};

}  // namespace sleight::physics
