// How archives of the 2D ball name things.
//
// Likeness distance of two animations: the largest difference between the places of equal-numbered
// collisions, landing included, in ball diameters.
// Thread safety: readers may be used from several threads.
#pragma once

#include <memory>

#include "common/archive/world_layout.h"
#include "worker/worlds/ball_2d/parameters.h"

namespace sleight::worlds::ball_2d {

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);

}  // namespace sleight::worlds::ball_2d
