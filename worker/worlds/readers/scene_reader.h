// The reader of archives of users' scenes.
//
// Likeness distance of two animations: the sum of two terms. The first is the greatest distance
// between a body's centres in the two animations, in diameters of the body, thirty times a second.
// The second is the difference between the numbers of collisions, divided by the larger number.
// Thread safety: readers may be used from several threads.
#pragma once

#include <memory>

#include "common/archive/world_layout.h"
#include "worker/worlds/user_scene/parameters.h"

namespace sleight::worlds::user_scene {

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);

}  // namespace sleight::worlds::user_scene
