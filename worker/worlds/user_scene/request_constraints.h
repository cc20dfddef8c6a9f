// Binds [[world.region]] and [constraint] of a scene. Private to this folder.
#pragma once

#include "common/request/binder.h"
#include "worker/worlds/user_scene/request_uncertain.h"

namespace sleight::worlds::user_scene {

/// A named box.
struct NamedRegion {
  std::string name;
  Region region;
};

void bind_regions(request::Binder& world, std::vector<NamedRegion>& regions);

/// `objects` is null if the scene has errors; then constraints aren't made.
void bind_constraints(request::Binder& constraint, Parameters& parameters,
                      const std::vector<NamedRegion>& regions, const ObjectNames* objects);

}  // namespace sleight::worlds::user_scene
