// Parts shared by several answers about an index: its table, numbers and features.
//
// Pure functions.
#pragma once

#include "clients/browse/index.h"
#include "clients/gallery_server/packed.h"
#include "common/json/value.h"
#include "common/math/vector.h"
#include "common/scene/scene.h"

namespace sleight::gallery {

/// Adds columns by entry: "is_find" u8, "chain" u32, "draw" f64, "in_proportion" u8, "end_s" and
/// "lineage" f64, and "number.K" f64 for each number.
void add_table(Packed& to, const browse::Index& index);

/// [x, y, z]
json::Value place_json(const math::Vec3& v);

/// [{"name", "unit"}]
json::Value numbers_json(const browse::Index& index);

/// [{"name", "kind", "twin_of", "body", "radius_m"}]
json::Value features_json(const scene::Scene& scene);

}  // namespace sleight::gallery
