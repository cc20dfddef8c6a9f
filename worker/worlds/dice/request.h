// The keys of the dice in a direction request. The file's lengths are in millimetres and its angles
// in degrees. The file counts dice from 1.
#pragma once

#include "common/request/direction_request.h"
#include "worker/worlds/dice/parameters.h"

namespace sleight::worlds::dice {

/// Binds the world "dice", whose requests have the world's Parameters (request::parameters_of).
request::WorldBinding request_binding();

}  // namespace sleight::worlds::dice
