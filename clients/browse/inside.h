// Computes when a body's centre is in a box, exactly from the closed form of its path.
//
// On each axis, a piece of path is a parabola in time, which is between two bounds in at most two
// time intervals. The centre is in the box where the intervals of the three axes overlap.
#pragma once

#include <limits>
#include <optional>
#include <span>

#include "clients/browse/index.h"

namespace sleight::browse {

/// A closed time interval. Default: all time.
struct Stretch {
  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();
  friend bool operator==(const Stretch&, const Stretch&) = default;
};

/// Returns the first moment within `when` at which the piece is in the box, or nothing. The piece
/// lasts from its start until `end_s`. Exact up to rounding.
std::optional<double> first_inside(const Piece& piece, double end_s, const Box& box,
                                   const Stretch& when);

/// Returns the first moment within `when` at which a body's centre is in the box, or nothing.
std::optional<double> first_inside(std::span<const Piece> pieces, const Box& box,
                                   const Stretch& when);

}  // namespace sleight::browse
