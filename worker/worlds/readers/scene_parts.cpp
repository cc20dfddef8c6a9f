#include "worker/worlds/readers/scene_parts.h"

#include <array>
#include <utility>

#include "common/base/check.h"

namespace sleight::worlds {
namespace {

std::uint32_t count_of(const auto& list) {
  return static_cast<std::uint32_t>(list.size());
}

/// Begins a part of the last feature; its triangles follow.
void begin_mesh(scene::Scene& scene) {
  CHECK(!scene.features.empty());
  scene.parts.push_back({.feature = count_of(scene.features) - 1,
                         .shape = scene::Shape::mesh,
                         .first_triangle = count_of(scene.triangles)});
}

void add_triangle(scene::Scene& scene, const std::array<std::uint32_t, 3>& corners) {
  scene.triangles.push_back(corners);
  ++scene.parts.back().triangles;
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

void add_mesh(scene::Scene& scene, const physics::TriangleMesh& mesh, std::uint32_t moving) {
  begin_mesh(scene);
  const std::uint32_t first = count_of(scene.vertices);
  for (std::uint32_t i = 0; i < mesh.vertices_m().size(); ++i)
    scene.vertices.push_back({.place_m = mesh.vertices_m()[i],
                              .offset = i < moving ? static_cast<std::int32_t>(i) : scene::k_none});
  for (const auto& [a, b, c] : mesh.triangles())
    add_triangle(scene, {first + a, first + b, first + c});
}

void add_polyhedron(scene::Scene& scene, const physics::ConvexPolyhedron& polyhedron) {
  begin_mesh(scene);
  const std::uint32_t first = count_of(scene.vertices);
  for (const math::Vec3& vertex : polyhedron.vertices_m())
    scene.vertices.push_back({.place_m = vertex});
  for (const physics::Face& face : polyhedron.faces()) {
    const auto sides = polyhedron.sides_of(face);
    for (std::size_t i = 1; i + 1 < sides.size(); ++i)
      add_triangle(scene,
                   {first + sides[0].vertex, first + sides[i].vertex, first + sides[i + 1].vertex});
  }
}

}  // namespace sleight::worlds
