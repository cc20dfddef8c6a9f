// All pairs of features: for the rare pairs where a search by steps is not certified, and for
// overlap. Internal to worker/physics/distance.
// Thread safety: pure functions.
#pragma once

#include "worker/physics/distance/feature_pairs.h"

namespace sleight::physics {

/// The closest pair among all that can be: given a unit axis along which the pieces are separated
/// by at least `low_m`, and that their gap is at most `high_m`, closest points lie within high_m -
/// low_m of the ends of the pieces along the axis, so only features with a vertex there are looked
/// at. Of pairs that are equally close to rounding, the one along whose normal the pieces are most
/// separated. REQUIRES: the bounds hold to rounding; the pieces are separated.
LocalClosest closest_of_all(const PiecePair& pair, const Vec3& axis, double low_m, double high_m);

/// The direction of greatest separation (of least depth, for overlapping pieces) among the normals
/// of faces and the products of edges. For overlapping pieces gap_m <= 0 is exactly that depth. A
/// positive gap_m is a lower bound of the gap.
LocalClosest least_overlap(const PiecePair& pair);

}  // namespace sleight::physics
