// The reader of 2D ball archives.
//
// Likeness distance of two animations: the greatest distance in ball diameters between collisions
// that have the same number. The landing counts as a collision.
// Thread safety: readers may be used from several threads.
#pragma once

#include <memory>

#include "common/archive/world_layout.h"
#include "worker/worlds/ball_2d/parameters.h"

namespace sleight::worlds::ball_2d {

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);

}  // namespace sleight::worlds::ball_2d
