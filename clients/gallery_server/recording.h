// An animation as columns of an answer (packed.h): its motion, and what it looks like by itself.
//
// Pure functions.
#pragma once

#include <string>

#include "clients/browse/archives/kept_animations.h"
#include "clients/gallery_server/packed.h"
#include "common/json/value.h"
#include "common/motion/path.h"
#include "common/scene/scene.h"

namespace sleight::gallery {

/// Adds the columns of all segments, bodies ascending, each name with `prefix` before it: "body",
/// "start_s", "mode", "cause", "partner", "position_m", "velocity_mps", "acceleration_mps2",
/// "orientation" (w, x, y, z), "angular_velocity_radps", "angular_acceleration_radps2".
void add_motion(Packed& to, const std::string& prefix, const motion::Animation& motion);

/// The same and its own meshes; returns its head: "name", "end_s", "meshes", "columns" (the
/// prefix).
json::Value add_animation(Packed& to, const std::string& prefix, const std::string& name,
                          const browse::KeptAnimation& animation, const scene::Scene& scene);

}  // namespace sleight::gallery
