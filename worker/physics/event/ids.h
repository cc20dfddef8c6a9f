// Ids of bodies and of static geometry. Thread safety: values.
#pragma once

#include "common/base/ids.h"

namespace sleight::physics {

/// A body's index in the scene.
using BodyId = base::Index<struct BodyTag>;
/// A face, an edge or a vertex of static geometry. Spheres meet features (static_geometry.h).
using FeatureId = base::Index<struct FeatureTag>;
/// A plane, a convex piece or a triangle. Bodies that aren't spheres meet pieces. A plane's
/// FeatureId and PieceId have the same index.
using PieceId = base::Index<struct PieceTag>;
/// Static geometry that a body meets. For a sphere: a feature. For other bodies: a piece or a
/// surface (surfaces are numbered after the pieces).
using StaticId = base::Index<struct StaticTag>;
/// A group of bodies and static geometry; CollisionFilter says which groups meet.
using CollisionGroup = base::Id<struct CollisionGroupTag, std::uint8_t>;

}  // namespace sleight::physics
