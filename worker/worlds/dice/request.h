// The keys of the dice in a direction request.
//
// Lengths are in millimetres in the file and angles in degrees; in Parameters in metres and
// radians. Dice are counted from 1 in the file.
#pragma once

#include "common/request/direction_request.h"
#include "worker/worlds/dice/parameters.h"

namespace sleight::worlds::dice {

/// The world "dice"; its requests have the world's Parameters (request::parameters_of).
request::WorldBinding request_binding();

}  // namespace sleight::worlds::dice
