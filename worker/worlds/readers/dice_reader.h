// How archives of dice name things.
//
// Segments show each die with the numbering that it has (numbering.h): orientations are
// those of the numbered die.
//
// Likeness distance of two animations: the greatest distance between the centres of a die in both
// at one time, of all dice and of times a sixtieth of a second apart, in sides of a die; plus the
// difference of their numbers of collisions with the table over the larger one.
// Thread safety: readers may be used from several threads.
#pragma once

#include <memory>

#include "common/archive/world_layout.h"
#include "worker/worlds/dice/parameters.h"

namespace sleight::worlds::dice {

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);

}  // namespace sleight::worlds::dice
