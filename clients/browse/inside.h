// When a body's centre is in a box: solved on the closed form of its path, never sampled.
//
// On each axis a piece of path is a parabola in time, which has at most two stretches between two
// bounds. The centre is in the box in the common part of the three axes' stretches.
#pragma once

#include <limits>
#include <optional>
#include <span>

#include "clients/browse/index.h"

namespace sleight::browse {

/// A stretch of time; its ends belong to it. The default is all time.
struct Stretch {
  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();
  friend bool operator==(const Stretch&, const Stretch&) = default;
};

/// The first moment within `when` at which the piece, in force from its start until `end_s`, is in
/// the box; nothing if it never is. Rounding apart, exact.
std::optional<double> first_inside(const Piece& piece, double end_s, const Box& box,
                                   const Stretch& when);

/// Likewise of all pieces of a body. Pieces that begin after `when` or end before are not looked
/// at.
std::optional<double> first_inside(std::span<const Piece> pieces, const Box& box,
                                   const Stretch& when);

}  // namespace sleight::browse
