// Random maps of friction for planes.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "common/math/vector.h"
#include "tests/scenes/shared/random_starts.h"
#include "worker/physics/collision/sphere_search.h"
#include "worker/physics/scene/friction_map.h"

namespace sleight::physics::testing {

/// Axes in a plane. The origin is the plane's point closest to the world's origin.
inline MapFrame frame_on(const HalfSpace& plane) {
  const Vec3& n = plane.normal;
  const Vec3 along = std::fabs(n.z()) > 0.5 ? Vec3::UnitX() : Vec3::UnitZ();
  const Vec3 v = math::normalized(math::cross(n, along));
  return {.origin_m = plane.offset_m * n, .u = math::cross(v, n), .v = v};
}

/// Rectangles that begin within size_m of the origin and may overlap. Some have no friction.
inline std::vector<FrictionRectangle> random_rectangles(random::Stream& stream, int count,
                                                        double size_m) {
  std::vector<FrictionRectangle> rectangles;
  for (int i = 0; i < count; ++i) {
    const double u_m = scenes::between(stream, -size_m, size_m);
    const double v_m = scenes::between(stream, -size_m, size_m);
    rectangles.push_back(
        {.u_min_m = u_m,
         .u_max_m = u_m + size_m * scenes::between(stream, 0.01, 0.5),
         .v_min_m = v_m,
         .v_max_m = v_m + size_m * scenes::between(stream, 0.01, 0.5),
         .friction = stream.uniform() < 0.2 ? 0 : scenes::between(stream, 0.02, 0.6)});
  }
  return rectangles;
}

inline std::shared_ptr<const FrictionMap> random_friction(random::Stream& stream,
                                                          const HalfSpace& plane, int count,
                                                          double size_m) {
  return std::make_shared<const FrictionMap>(
      FrictionMap::make(frame_on(plane), random_rectangles(stream, count, size_m)).value());
}

}  // namespace sleight::physics::testing
