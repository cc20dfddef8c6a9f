// The keys of the balls that spell in a direction request, with the thesis's values as defaults.
//
// Lengths are in millimetres in the file and in metres in Parameters.
#pragma once

#include "common/request/direction_request.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds::spelling {

/// The world "spelling"; its requests have the world's Parameters (request::parameters_of).
request::WorldBinding request_binding();

}  // namespace sleight::worlds::spelling
