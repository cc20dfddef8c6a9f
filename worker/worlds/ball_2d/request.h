// The 2D ball's keys in a direction request, with the thesis's values as defaults.
//
// Angles are in degrees in the file and in radians in Parameters; lengths are in ball diameters D.
#pragma once

#include "common/request/direction_request.h"
#include "worker/worlds/ball_2d/parameters.h"

namespace sleight::worlds::ball_2d {

/// The world "ball_2d", bound to `parameters`, which must outlive the binding. Reading a request
/// sets every one of them. Not thread-safe for the same `parameters`.
request::WorldBinding request_binding(Parameters& parameters);

}  // namespace sleight::worlds::ball_2d
