// What events, predictions and contacts name: bodies, and what of static geometry they meet.
//
// Thread safety: values.
#pragma once

#include "common/base/ids.h"

namespace sleight::physics {

/// A moving body: its index in the scene.
using BodyId = base::Index<struct BodyTag>;
/// What a sphere meets: a face, an edge or a vertex of static geometry (static_geometry.h).
using FeatureId = base::Index<struct FeatureTag>;
/// What another body meets: a plane, a convex or a triangle. A plane has the same index as a
/// feature.
using PieceId = base::Index<struct PieceTag>;
/// Either, by what the body is: of a sphere a feature; of another body a piece, or, after these, a
/// surface.
using StaticId = base::Index<struct StaticTag>;

}  // namespace sleight::physics
