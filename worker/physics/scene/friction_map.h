// Friction that differs from place to place on a plane: rectangles, as the oil on a bowling lane.
//
// A rectangle holds the points with u_min <= u < u_max and v_min <= v < v_max, where u and v are
// coordinates along two axes of the plane. Of rectangles that overlap the later one counts, as if
// painted over the earlier; where there is none, the scene's table of contacts says what friction
// is.
//
// Idea. What slides or rolls on one plane moves along a parabola as long as friction stays. A
// border is met where that parabola crosses the sides of a rectangle: quadratic equations. Which
// rectangles come into question is asked of a tree of boxes. Where many lie side by side, the way
// to the end of the present one is all that is looked at.
//
// Invariant: between a path's point and border_s later the rectangle that counts is the same one,
// but for rounding. Thread safety: const functions may run at once.
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
  double friction = 0;  ///< Coulomb's mu, 0 to 1e6, of whatever touches the plane there
  bool operator==(const FrictionRectangle&) const = default;
};

/// Coordinates of a point: u.(point - origin) and v.(point - origin).
struct MapFrame {
  Vec3 origin_m = Vec3::Zero();
  Vec3 u = Vec3::UnitX();  ///< unit vectors, across each other and the plane's normal
  Vec3 v = Vec3::UnitY();
};

/// A way that begins at a point, with constant acceleration.
struct MapPath {
  Vec3 place_m = Vec3::Zero();
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 acceleration_mps2 = Vec3::Zero();
};

class FrictionMap {
 public:
  static constexpr std::size_t k_rectangles_max = 4096;

  /// Fails with a sentence that says which rectangle or axis is wrong, and how.
  static base::Result<FrictionMap, std::string> make(const MapFrame& frame,
                                                     std::vector<FrictionRectangle> rectangles);

  /// Where no rectangle is: nothing.
  std::optional<double> friction_at(const Vec3& point_m) const;
  /// After how long another rectangle counts, or none; `most_s` if none does before.
  double border_s(const MapPath& path, double most_s) const;

  const MapFrame& frame() const { return frame_; }
  /// Whether they say the same of every point.
  bool same_as(const FrictionMap& other) const;

 private:
  struct Plane2 {
    double u = 0;
    double v = 0;
  };
  FrictionMap(const MapFrame& frame, std::vector<FrictionRectangle> rectangles);
  Plane2 coordinates(const Vec3& vector) const;
  /// Index of the last rectangle at a point, plus 1; 0 if there is none.
  std::size_t count_at(const Plane2& place) const;

  MapFrame frame_;
  std::vector<FrictionRectangle> rectangles_;
  BoxTree tree_;
};

}  // namespace sleight::physics
