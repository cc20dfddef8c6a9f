// The keys of a user's scene in a direction request: world "scene".
#pragma once

#include <string_view>

#include "common/request/direction_request.h"
#include "worker/worlds/user_scene/parameters.h"

namespace sleight::worlds::user_scene {

/// Binds the world "scene". Its requests have Parameters (request::parameters_of). The binding
/// makes every shape once, so that errors of shapes have places in the file, and then builds the
/// scene.
request::WorldBinding request_binding();

/// Returns the value of the key `shape`, such as "rounded_box".
std::string_view name_of(ShapeKind kind);

}  // namespace sleight::worlds::user_scene
