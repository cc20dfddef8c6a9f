#include "worker/worlds/scene_parts/scene_parts.h"

#include <utility>
#include <vector>

#include "common/base/check.h"

namespace sleight::worlds {
namespace {

std::uint32_t count_of(const auto& list) {
  return static_cast<std::uint32_t>(list.size());
}

}  // namespace

std::uint32_t add_feature(scene::Scene& scene, scene::FeatureKind kind, std::string name) {
  const std::uint32_t number = count_of(scene.features);
  scene.features.push_back({.name = std::move(name), .kind = kind, .twin_of = number});
  return number;
}

void add_part(scene::Scene& scene, scene::Shape shape, const math::Vec3& size_m,
              const math::Vec3& position_m) {
  CHECK(!scene.features.empty());
  scene.parts.push_back({.feature = count_of(scene.features) - 1,
                         .shape = shape,
                         .size_m = size_m,
                         .position_m = position_m});
}

void add_triangles(scene::Scene& scene, std::span<const math::Vec3> points_m,
                   std::span<const physics::TriangleCorners> triangles) {
  add_part(scene, scene::Shape::mesh, math::Vec3::Zero());
  scene.parts.back().first_triangle = count_of(scene.triangles);
  scene.parts.back().triangles = count_of(triangles);
  const std::uint32_t first = count_of(scene.vertices);
  for (const math::Vec3& point_m : points_m)
    scene.vertices.push_back({.place_m = point_m});
  for (const auto& [a, b, c] : triangles)
    scene.triangles.push_back({first + a, first + b, first + c});
}

void add_mesh(scene::Scene& scene, const physics::TriangleMesh& mesh, std::uint32_t moving) {
  const std::uint32_t first = count_of(scene.vertices);
  add_triangles(scene, mesh.vertices_m(), mesh.triangles());
  for (std::uint32_t i = 0; i < moving; ++i)
    scene.vertices[first + i].offset = static_cast<std::int32_t>(i);
}

void add_polyhedron(scene::Scene& scene, const physics::ConvexPolyhedron& polyhedron) {
  std::vector<physics::TriangleCorners> triangles;
  for (const physics::Face& face : polyhedron.faces()) {
    const auto sides = polyhedron.sides_of(face);
    for (std::size_t i = 1; i + 1 < sides.size(); ++i)
      triangles.push_back({sides[0].vertex, sides[i].vertex, sides[i + 1].vertex});
  }
  add_triangles(scene, polyhedron.vertices_m(), triangles);
}

}  // namespace sleight::worlds
