// The keys of the balls that spell in a direction request. Defaults are the thesis's values. The
// file's lengths are in millimetres.
#pragma once

#include "common/request/direction_request.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds::spelling {

/// Binds the world "spelling", whose requests have the world's Parameters (request::parameters_of).
request::WorldBinding request_binding();

}  // namespace sleight::worlds::spelling
