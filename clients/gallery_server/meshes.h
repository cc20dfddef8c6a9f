// How features of a scene look, as columns of an answer (packed.h): the triangles that exported
// files have (clients/export/look.h), so that page and files show the same.
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

/// Features that look otherwise in each animation, ascending: with vertices that are moved, with
/// control points below them, with parts of their own.
std::vector<std::uint32_t> own_features(const scene::Scene& scene);
/// Of one animation: those, and whatever features its own parts are of.
std::vector<std::uint32_t> own_features(const scene::Scene& scene, const scene::Variation& own);
/// All others of the scene.
std::vector<std::uint32_t> common_features(const scene::Scene& scene);

/// Adds the columns of these features, each name with `prefix` before it, and returns the answer's
/// "meshes": of each its feature, colour, opacity, whether it is double-sided, and its columns.
json::Value add_meshes(Packed& to, const std::string& prefix, const scene::Scene& scene,
                       std::span<const std::uint32_t> features, const scene::Variation& own,
                       std::span<const math::Vec3> offsets_m);

/// Radius of a ball about a body's centre that holds it.
double radius_m(const scene::Scene& scene, std::uint32_t body);

}  // namespace sleight::gallery
