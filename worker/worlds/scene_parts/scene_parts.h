// Builds scene descriptions (common/scene) from simulator objects.
// Thread safety: pure functions of their arguments.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "common/scene/scene.h"
#include "worker/physics/shape/convex_polyhedron.h"
#include "worker/physics/shape/triangle_mesh.h"

namespace sleight::worlds {

/// Adds a scene feature and returns its number. REQUIRES: bodies are added first, then fixed
/// features, then goals.
std::uint32_t add_feature(scene::Scene& scene, scene::FeatureKind kind, std::string name);

/// Appends a part to the last added feature.
void add_part(scene::Scene& scene, scene::Shape shape, const math::Vec3& size_m,
              const math::Vec3& position_m = {0, 0, 0});
/// Appends a mesh to the last added feature. The offset variable's rows move the mesh's first
/// `moving` vertices: row i moves vertex i.
void add_mesh(scene::Scene& scene, const physics::TriangleMesh& mesh, std::uint32_t moving);
/// Appends a mesh that doesn't change.
void add_triangles(scene::Scene& scene, std::span<const math::Vec3> points_m,
                   std::span<const physics::TriangleCorners> triangles);
void add_polyhedron(scene::Scene& scene, const physics::ConvexPolyhedron& polyhedron);

}  // namespace sleight::worlds
