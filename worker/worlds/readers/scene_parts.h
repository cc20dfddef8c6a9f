// Makes scenes (common/scene) of what simulators have.
//
// Thread safety: pure functions of their arguments.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "common/scene/scene.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/triangle_mesh.h"

namespace sleight::worlds {

/// Its number. REQUIRES: bodies come first, then what is fixed, then goals.
std::uint32_t add_feature(scene::Scene& scene, scene::FeatureKind kind, std::string name);

/// Parts of the feature that was added last.
void add_part(scene::Scene& scene, scene::Shape shape, const math::Vec3& size_m,
              const math::Vec3& position_m = {0, 0, 0});
/// The first `moving` vertices are moved by the rows of the same numbers of the offset variable.
void add_mesh(scene::Scene& scene, const physics::TriangleMesh& mesh, std::uint32_t moving);
void add_polyhedron(scene::Scene& scene, const physics::ConvexPolyhedron& polyhedron);

}  // namespace sleight::worlds
