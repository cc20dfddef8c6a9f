// The looks of a scene's features as columns of an answer (packed.h). The triangles equal those of
// exported files (clients/export/look.h).
//
// Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clients/gallery_server/packed.h"
#include "common/json/value.h"
#include "common/scene/scene.h"

namespace sleight::gallery {

/// Returns the features whose look differs between animations because of moved vertices or control
/// points, ascending.
std::vector<std::uint32_t> own_features(const scene::Scene& scene);
/// Returns the features with an individual look in this animation, including those of its own
/// parts.
std::vector<std::uint32_t> own_features(const scene::Scene& scene, const scene::Variation& own);
/// Returns the features that own_features(scene) omits.
std::vector<std::uint32_t> common_features(const scene::Scene& scene);

/// Adds the features' columns, with `prefix` before each name. Returns the answer's "meshes":
/// feature, colour, opacity, whether the mesh is double-sided, and its columns.
json::Value add_meshes(Packed& to, const std::string& prefix, const scene::Scene& scene,
                       std::span<const std::uint32_t> features, const scene::Variation& own,
                       std::span<const math::Vec3> offsets_m);

/// Radius of a ball around a body's centre that contains the body.
double radius_m(const scene::Scene& scene, std::uint32_t body);

}  // namespace sleight::gallery
