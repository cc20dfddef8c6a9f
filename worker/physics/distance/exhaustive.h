// Searches all pairs of features. Used if pieces overlap, and in the rare cases in which GJK's
// result isn't certified. Internal to worker/physics/distance. Thread safety: pure functions.
#pragma once

#include "worker/physics/distance/feature_pairs.h"

namespace sleight::physics {

/// Returns the closest pair of features. The pieces are separated by at least `low_m` along a unit
/// axis, and their gap is at most `high_m`. So closest points are within high_m - low_m of the
/// pieces' ends along the axis. Only features with a vertex in this range are examined. If several
/// pairs are equally close up to rounding, the result is the pair with the greatest separation
/// along its normal. REQUIRES: the bounds hold up to rounding; the pieces are separated.
LocalClosest closest_of_all(const PiecePair& pair, const Vec3& axis, double low_m, double high_m);

/// Returns the direction of greatest separation among face normals and products of edges. If the
/// pieces overlap, this is the direction of least depth. If gap_m <= 0, the depth is exactly
/// -gap_m. A positive gap_m is a lower bound of the gap.
LocalClosest least_overlap(const PiecePair& pair);

}  // namespace sleight::physics
