// A scene's things as flat shapes, seen from above or from the front: what pictures are made of.
//
// Lengths in millimetres, z up. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clients/plot/figure.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::pictures {

inline constexpr double k_mm_per_m = 1000;

/// Either way x goes to the right.
enum class Seen {
  from_above,  ///< y goes up
  from_front   ///< from low y: z goes up
};

/// One flat piece of a thing: a polygon, or a disc.
struct FlatPiece {
  std::vector<plot::Point> corners_mm{};  ///< in order; empty of a disc
  plot::Point middle_mm{};
  double radius_mm = 0;  ///< of a disc
  double depth_mm = 0;   ///< larger: nearer to the viewer
  double height_mm = 0;  ///< z of its middle
  /// Of a die: which face; 0 of other things.
  std::uint32_t face = 0;
  std::vector<std::vector<plot::Point>> pips_mm{};
};

/// Where a place is seen, and how near it is to the viewer.
plot::Point projected(const math::Vec3& place, Seen seen);  ///< in the place's unit
plot::Point projected_mm(const math::Vec3& place_m, Seen seen);
double depth_mm(const math::Vec3& place_m, Seen seen);

/// The pieces of a part that look towards the viewer, the furthest first: its facets, but a disc of
/// a sphere. `pose`: the body's, or none for what stands still. `offsets_m` move vertices of
/// meshes.
std::vector<FlatPiece> flat_pieces(const scene::Scene& scene, const scene::Part& part,
                                   const motion::Pose& pose, Seen seen,
                                   std::span<const math::Vec3> offsets_m);

/// How far a body's parts reach from its centre.
double reach_mm(const scene::Scene& scene, std::uint32_t body);

/// The parts of a feature. REQUIRES: parts ascend by feature.
std::span<const scene::Part> parts_of(std::span<const scene::Part> parts, std::uint32_t feature);

}  // namespace sleight::pictures
