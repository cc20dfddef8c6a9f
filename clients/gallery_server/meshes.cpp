#include "clients/gallery_server/meshes.h"

#include <fmt/format.h>

#include <algorithm>

#include "clients/export/look.h"

namespace sleight::gallery {
namespace {

bool has_moved_vertex(const scene::Scene& scene, const scene::Part& part) {
  if (part.shape != scene::Shape::mesh) return false;
  for (std::uint32_t i = 0; i < part.triangles; ++i) {
    for (const std::uint32_t vertex : scene.triangles[part.first_triangle + i])
      if (scene.vertices[vertex].offset != scene::k_none) return true;
  }
  return false;
}

/// Whether the part's look depends on the animation's control points. A goal's ring follows the
/// surface below it.
bool hangs_on_points(const scene::Scene& scene, const scene::Part& part) {
  return scene.has_own_points && (part.shape == scene::Shape::surface ||
                                  scene.features[part.feature].kind == scene::FeatureKind::wanted);
}

std::vector<float> flat(std::span<const gltf::Float3> triples) {
  std::vector<float> numbers;
  numbers.reserve(3 * triples.size());
  for (const gltf::Float3& triple : triples)
    numbers.insert(numbers.end(), triple.begin(), triple.end());
  return numbers;
}

double reach_m(const scene::Part& part, const scene::Scene& scene) {
  switch (part.shape) {
    case scene::Shape::sphere:
    case scene::Shape::disc:
      return part.size_m.x() / 2;
    case scene::Shape::mesh: {
      double reach = 0;
      for (std::uint32_t i = 0; i < part.triangles; ++i) {
        for (const std::uint32_t vertex : scene.triangles[part.first_triangle + i])
          reach = std::max(reach, scene.vertices[vertex].place_m.norm());
      }
      return reach;
    }
    default:
      return part.size_m.norm() / 2;
  }
}

}  // namespace

std::vector<std::uint32_t> own_features(const scene::Scene& scene) {
  std::vector<std::uint32_t> own;
  for (const scene::Part& part : scene.parts) {
    if ((hangs_on_points(scene, part) || has_moved_vertex(scene, part)) &&
        (own.empty() || own.back() != part.feature))
      own.push_back(part.feature);
  }
  return own;
}

std::vector<std::uint32_t> own_features(const scene::Scene& scene, const scene::Variation& own) {
  std::vector<std::uint32_t> features = own_features(scene);
  for (const scene::Part& part : own.parts)
    features.push_back(part.feature);
  std::ranges::sort(features);
  features.erase(std::unique(features.begin(), features.end()), features.end());
  return features;
}

std::vector<std::uint32_t> common_features(const scene::Scene& scene) {
  const std::vector<std::uint32_t> own = own_features(scene);
  std::vector<std::uint32_t> common;
  for (std::uint32_t feature = 0; feature < scene.features.size(); ++feature)
    if (!std::ranges::binary_search(own, feature)) common.push_back(feature);
  return common;
}

json::Value add_meshes(Packed& to, const std::string& prefix, const scene::Scene& scene,
                       std::span<const std::uint32_t> features, const scene::Variation& own,
                       std::span<const math::Vec3> offsets_m) {
  json::Value meshes = json::Value::array();
  for (const std::uint32_t feature : features) {
    for (const gltf::Primitive& primitive : gltf::look_of(scene, feature, own, offsets_m)) {
      const std::size_t number = meshes.size();
      const auto named = [&](char what) { return fmt::format("{}{}{}", prefix, what, number); };
      to.add(named('p'), flat(primitive.places));
      to.add(named('n'), flat(primitive.normals));
      to.add(named('c'), std::span<const std::uint32_t>(primitive.corners));
      const plot::Color& color = primitive.material.color;
      meshes.push_back(
          {{"feature", feature},
           {"colour", fmt::format("#{:02x}{:02x}{:02x}", color.red, color.green, color.blue)},
           {"opacity", color.opacity},
           {"double_sided", primitive.material.is_double_sided},
           {"places", named('p')},
           {"normals", named('n')},
           {"corners", named('c')}});
    }
  }
  return meshes;
}

double radius_m(const scene::Scene& scene, std::uint32_t body) {
  double radius = 0;
  for (const scene::Part& part : scene.parts) {
    if (part.feature == body)
      radius = std::max(radius, part.position_m.norm() + reach_m(part, scene));
  }
  return radius;
}

}  // namespace sleight::gallery
