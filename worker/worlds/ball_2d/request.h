// The 2D ball's keys in a direction request. Defaults are the thesis's values. The file's angles
// are in degrees and its lengths in ball diameters D.
#pragma once

#include "common/request/direction_request.h"
#include "worker/worlds/ball_2d/parameters.h"

namespace sleight::worlds::ball_2d {

/// Binds the world "ball_2d", whose requests have the world's Parameters (request::parameters_of).
request::WorldBinding request_binding();

}  // namespace sleight::worlds::ball_2d
