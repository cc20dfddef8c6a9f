// Converts parts of a scene description to flat shapes, seen from above or from the front. Lengths
// are in millimetres, z up. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clients/plot/figure.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::pictures {

inline constexpr double k_mm_per_m = 1000;

/// In both views, x points right.
enum class Seen {
  from_above,  ///< y points up
  from_front   ///< seen from low y: z points up
};

/// A polygon or a disc.
struct FlatPiece {
  std::vector<plot::Point> corners_mm{};  ///< in order; empty for a disc
  plot::Point middle_mm{};
  double radius_mm = 0;  ///< 0 for a polygon
  double depth_mm = 0;   ///< larger is nearer to the viewer
  double height_mm = 0;  ///< z of the middle
  /// 1 to 6: face of a die; 0: other things.
  std::uint32_t face = 0;
  std::vector<std::vector<plot::Point>> pips_mm{};
};

/// Return where a place is seen, and how near it is to the viewer.
plot::Point projected(const math::Vec3& place, Seen seen);  ///< in the unit of `place`
plot::Point projected_mm(const math::Vec3& place_m, Seen seen);
double depth_mm(const math::Vec3& place_m, Seen seen);

/// Returns the pieces of a part that face the viewer, the furthest first: its facets, or a disc for
/// a sphere. `pose`: the body's pose; the default for fixed things. `offsets_m` move vertices of
/// meshes.
std::vector<FlatPiece> flat_pieces(const scene::Scene& scene, const scene::Part& part,
                                   const motion::Pose& pose, Seen seen,
                                   std::span<const math::Vec3> offsets_m);

/// Returns the maximum distance of a body's parts from its centre.
double reach_mm(const scene::Scene& scene, std::uint32_t body);

/// Returns the parts of a scene feature. REQUIRES: parts are sorted by feature.
std::span<const scene::Part> parts_of(std::span<const scene::Part> parts, std::uint32_t feature);

}  // namespace sleight::pictures
