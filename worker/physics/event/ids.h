// Ids of bodies and of the static geometry that they meet. Thread safety: values.
#pragma once

#include "common/base/ids.h"

namespace sleight::physics {

/// A moving body: its index in the scene.
using BodyId = base::Index<struct BodyTag>;
/// A face, an edge or a vertex of static geometry, which spheres meet (static_geometry.h).
using FeatureId = base::Index<struct FeatureTag>;
/// A plane, a convex piece or a triangle, which other bodies meet. A plane's FeatureId and PieceId
/// have the same index.
using PieceId = base::Index<struct PieceTag>;
/// Static geometry that a body meets: a feature if the body is a sphere, otherwise a piece or a
/// surface (numbered after the pieces).
using StaticId = base::Index<struct StaticTag>;

}  // namespace sleight::physics
