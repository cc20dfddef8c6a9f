// The 2D ball's keys in a direction request, with the thesis's values as defaults.
//
// Angles are in degrees in the file and in radians in Parameters; lengths are in ball diameters D.
#pragma once

#include "common/request/direction_request.h"
#include "worker/worlds/ball_2d/parameters.h"

namespace sleight::worlds::ball_2d {

/// The world "ball_2d"; its requests have the world's Parameters (request::parameters_of).
request::WorldBinding request_binding();

}  // namespace sleight::worlds::ball_2d
