// An animation as columns of an answer (packed.h): its motion and its own looks.
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

/// Adds a column for each field (common/motion/fields.h), with `prefix` before its name.
void add_segments(Packed& to, const std::string& prefix, std::span<const motion::Segment> segments);

/// Adds the columns of all segments, in the order of bodies, and the animation's own meshes.
/// Returns the animation's head: "name", "end_s", "meshes", "columns" (the prefix).
json::Value add_animation(Packed& to, const std::string& prefix, const std::string& name,
                          const browse::KeptAnimation& animation, const scene::Scene& scene);

}  // namespace sleight::gallery
