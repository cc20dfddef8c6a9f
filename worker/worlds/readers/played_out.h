// Reports how a satisfying state's simulation to rest ended.
#pragma once

#include "common/archive/world_layout.h"

namespace sleight::worlds {

template <class World>
archive::PlaysOut played_out(const World& world, const typename World::Outcome& outcome) {
  if (world.failure(outcome) != nullptr) return archive::PlaysOut::failed;
  return world.satisfied(outcome) ? archive::PlaysOut::yes : archive::PlaysOut::otherwise;
}

}  // namespace sleight::worlds
