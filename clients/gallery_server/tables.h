// What several answers say of an index: its table, its numbers and features.
//
// Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "clients/browse/index.h"
#include "clients/gallery_server/packed.h"
#include "common/math/vector.h"
#include "common/scene/scene.h"

namespace sleight::gallery {

/// Columns over entries: "is_find" u8, "chain" u32, "draw" f64, "in_proportion" u8, "end_s" and
/// "lineage" f64, and "number.K" f64 of each number.
void add_table(Packed& to, const browse::Index& index);

/// [x, y, z]
nlohmann::ordered_json place_json(const math::Vec3& v);

/// [{"name", "unit"}]
nlohmann::ordered_json numbers_json(const browse::Index& index);

/// [{"name", "kind", "twin_of", "body", "radius_m"}]
nlohmann::ordered_json features_json(const scene::Scene& scene);

}  // namespace sleight::gallery
