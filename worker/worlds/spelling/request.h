// The keys of the balls that spell in a direction request, with the thesis's values as defaults.
//
// Lengths are in millimetres in the file and in metres in Parameters.
#pragma once

#include "common/request/direction_request.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds::spelling {

/// The world "spelling", bound to `parameters`, which must outlive the binding. Reading a request
/// sets every one of them. Not thread-safe for the same `parameters`.
request::WorldBinding request_binding(Parameters& parameters);

}  // namespace sleight::worlds::spelling
