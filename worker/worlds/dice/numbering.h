// The faces of a die, and the 24 ways to number them.
//
// In its own frame, a die has face 1 on the side of +x, face 2 on +y and face 3 on +z. Opposite
// faces add up to 7: face 4 is on -z, face 5 on -y and face 6 on -x. Seen from outside, faces 1, 2
// and 3 are anticlockwise round their common corner.
//
// Idea. If a cube is first turned by one of its 24 rotations, a throw moves it in the same way, but
// it shows other faces. So one motion of an unnumbered cube stands for 24 throws of a die. For
// numbering s, rotation s turned the die in the cube's frame; rotation 0 is the identity.
// Thread safety: pure functions.
#pragma once

#include <cstdint>

#include "common/math/rotation.h"
#include "common/math/vector.h"

namespace sleight::worlds::dice {

using math::Quat;
using math::Vec3;

inline constexpr std::uint32_t k_faces = 6;
inline constexpr std::uint32_t k_numberings = 24;

struct AxisDirection {
  std::uint8_t axis = 0;  ///< x, y, z
  std::int8_t sign = 1;
  friend bool operator==(const AxisDirection&, const AxisDirection&) = default;
};

/// Returns a face's direction in the cube's frame.
/// REQUIRES: 1 <= face <= 6, numbering < k_numberings.
AxisDirection direction_of_face(std::uint32_t face, std::uint32_t numbering);

/// Returns the rotation from the numbered die's frame to the cube's frame.
Quat rotation_of_numbering(std::uint32_t numbering);

/// Returns an orientation that has this face up. The orientation results from the identity by two
/// turns: the smallest turn that brings the face up, and then a turn by yaw_rad about the vertical.
Quat orientation_with_face_up(std::uint32_t face, double yaw_rad);

}  // namespace sleight::worlds::dice
