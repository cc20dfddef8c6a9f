// The readers of the worlds' archives.
//
// Each world has its own likeness distance of two animations:
//   - ball_2d: the greatest distance in ball diameters between collisions that have the same
//   number.
//     The landing counts as a collision.
//   - spelling: the share of designated bins that don't have the same ball in both animations.
//   - dice and scene: the sum of two terms. The first is the greatest distance between a body's
//     centres in the two animations, in sides of a die or diameters of a body, at every sixtieth
//     (dice) or thirtieth (scene) of a second. The second is the difference between the numbers of
//     collisions (of dice: with the table), divided by the larger number.
// Segments show each die with its shown numbering (dice/numbering.h), so orientations refer to the
// numbered die.
// Thread safety: readers may be used from several threads.
#pragma once

#include <memory>

#include "common/archive/world_layout.h"
#include "worker/worlds/ball_2d/parameters.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/spelling/parameters.h"
#include "worker/worlds/user_scene/parameters.h"

namespace sleight::worlds {

namespace ball_2d {
std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);
}
namespace dice {
std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);
}
namespace spelling {
std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);
}
namespace user_scene {
std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);
}

}  // namespace sleight::worlds
