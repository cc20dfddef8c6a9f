// The reader of dice archives.
//
// Segments show each die with its shown numbering (numbering.h), so orientations refer to the
// numbered die.
//
// Likeness distance of two animations: the sum of two terms. The first term is the greatest
// distance between a die's centres in the two animations, in sides of a die. This distance covers
// all dice at every sixtieth of a second. The second term is the difference between the numbers of
// collisions with the table, divided by the larger number. Thread safety: readers may be used from
// several threads.
#pragma once

#include <memory>

#include "common/archive/world_layout.h"
#include "worker/worlds/dice/parameters.h"

namespace sleight::worlds::dice {

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);

}  // namespace sleight::worlds::dice
