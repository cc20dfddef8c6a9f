// How a die looks from above and from the front: a cube's faces and their pips, as polygons.
//
// In its own frame a die has its 1 on the side of +x, 2 on +y, 3 on +z, and opposite faces add up
// to 7: so archives of dice number it. Lengths in millimetres, z up. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "clients/plot/figure.h"
#include "common/math/rotation.h"
#include "common/math/vector.h"

namespace sleight::pictures {

inline constexpr std::uint32_t k_die_faces = 6;
inline constexpr std::size_t k_pip_corners = 12;

struct DiePose {
  math::Vec3 centre_mm{0, 0, 0};
  math::Quat orientation = math::Quat::Identity();  ///< from the die's frame to the table's
};

/// Either way x goes to the right.
enum class Seen {
  from_above,  ///< y goes up
  from_front   ///< from low y: z goes up
};

/// A face that is seen has an outward normal with at least this part towards the viewer.
inline constexpr double k_facing_min = 0.02;

double towards_viewer(const math::Vec3& direction, Seen seen);

plot::Point projected(const math::Vec3& place_mm, Seen seen);

struct SeenFace {
  std::uint32_t face = 0;                                         ///< 1 to 6
  std::array<plot::Point, 4> corners_mm{};                        ///< in order
  std::vector<std::array<plot::Point, k_pip_corners>> pips_mm{};  ///< as many as its number
};

/// The faces that look towards the viewer, by number: three at most. They don't overlap. Those seen
/// all but from the side are left out.
std::vector<SeenFace> seen_faces(const DiePose& pose, double side_mm, Seen seen);

/// Which face is most upwards.
std::uint32_t upper_face(const math::Quat& orientation);

}  // namespace sleight::pictures
