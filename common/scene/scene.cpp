#include "common/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

namespace sleight::scene {
namespace {

constexpr double k_number_max = 1e9;
constexpr double k_norm_off_max = 1e-3;

bool is_sane(const Vec3& v) {
  // False for NaN.
  return std::abs(v.x()) <= k_number_max && std::abs(v.y()) <= k_number_max &&
         std::abs(v.z()) <= k_number_max;
}

bool is_rotation(const Quat& q) {
  const double square = q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z();
  return std::abs(square - 1) <= k_norm_off_max;
}

std::string fault_of_features(const Scene& scene) {
  std::set<std::string_view> names;
  FeatureKind last = FeatureKind::body;
  const std::uint32_t bodies = scene.bodies();
  for (std::size_t i = 0; i < scene.features.size(); ++i) {
    const Feature& feature = scene.features[i];
    if (feature.name.empty()) return fmt::format("feature {} has no name", i);
    if (!names.insert(feature.name).second)
      return fmt::format("two features are named '{}'", feature.name);
    if (feature.kind < last)
      return "features are not ordered by kind: bodies, then fixed, then wanted";
    last = feature.kind;
    const bool is_body = feature.kind == FeatureKind::body;
    if (feature.twin_of > i || (!is_body && feature.twin_of != i) ||
        scene.features[feature.twin_of].twin_of != feature.twin_of)
      return fmt::format("'{}' is not a twin of feature {}", feature.name, feature.twin_of);
    if (feature.body != k_none && (feature.kind != FeatureKind::wanted || feature.body < 0 ||
                                   static_cast<std::uint32_t>(feature.body) >= bodies))
      return fmt::format("'{}' refers to an invalid body", feature.name);
  }
  return {};
}

}  // namespace

std::uint32_t Scene::bodies() const {
  const auto end =
      std::ranges::find_if(features, [](const Feature& f) { return f.kind != FeatureKind::body; });
  return static_cast<std::uint32_t>(end - features.begin());
}

std::optional<std::uint32_t> Scene::find(std::string_view name) const {
  const auto found = std::ranges::find(features, name, &Feature::name);
  if (found == features.end()) return std::nullopt;
  return static_cast<std::uint32_t>(found - features.begin());
}

std::string fault_of_parts(std::span<const Part> parts, const Scene& scene) {
  std::uint32_t last = 0;
  for (const Part& part : parts) {
    if (part.feature >= scene.features.size() || part.feature < last)
      return "parts are not in the order of their features";
    last = part.feature;
    const bool is_sound = is_sane(part.size_m) && part.size_m.minCoeff() >= 0 &&
                          is_sane(part.position_m) && is_rotation(part.orientation);
    if (!is_sound)
      return fmt::format("a part of '{}' has invalid numbers", scene.features[part.feature].name);
    const auto end = std::uint64_t{part.first_triangle} + part.triangles;
    if (end > scene.triangles.size() || (part.shape != Shape::mesh && part.triangles > 0))
      return fmt::format("a part of '{}' refers to missing triangles",
                         scene.features[part.feature].name);
  }
  return {};
}

std::string fault_of(const Scene& scene) {
  if (std::string fault = fault_of_features(scene); !fault.empty()) return fault;
  if (std::string fault = fault_of_parts(scene.parts, scene); !fault.empty()) return fault;
  for (const Vertex& vertex : scene.vertices) {
    if (!is_sane(vertex.place_m) || vertex.offset < k_none) return "a vertex has invalid numbers";
    if (vertex.offset != k_none && scene.offset_variable.empty())
      return "vertices have offsets, but offset_variable is missing";
  }
  for (const auto& triangle : scene.triangles) {
    for (const std::uint32_t vertex : triangle) {
      if (vertex >= scene.vertices.size()) return "a triangle refers to a missing vertex";
    }
  }
  if (!is_sane(scene.low_m) || !is_sane(scene.high_m) ||
      (scene.high_m - scene.low_m).minCoeff() < 0)
    return "the view box has invalid numbers";
  return {};
}

}  // namespace sleight::scene
