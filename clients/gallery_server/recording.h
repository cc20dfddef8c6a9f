// An animation as columns of an answer (packed.h): its motion, and what it looks like by itself.
//
// Pure functions.
#pragma once

#include <span>
#include <string>

#include "clients/browse/archives/kept_animations.h"
#include "clients/gallery_server/packed.h"
#include "common/json/value.h"
#include "common/motion/segment.h"
#include "common/scene/scene.h"

namespace sleight::gallery {

/// Adds a column of each field (common/motion/fields.h), its name with `prefix` before it.
void add_segments(Packed& to, const std::string& prefix, std::span<const motion::Segment> segments);

/// Adds the columns of all segments, bodies ascending, and its own meshes; returns its head:
/// "name", "end_s", "meshes", "columns" (the prefix).
json::Value add_animation(Packed& to, const std::string& prefix, const std::string& name,
                          const browse::KeptAnimation& animation, const scene::Scene& scene);

}  // namespace sleight::gallery
