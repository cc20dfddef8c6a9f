// Decodes a state, and reports how a satisfying state's simulation to rest ended.
#pragma once

#include <utility>

#include "common/archive/world_layout.h"
#include "common/base/check.h"

namespace sleight::worlds {

/// REQUIRES: the world's worker produced `bytes`.
template <class World>
typename World::State decoded(const World& world, base::BytesView bytes) {
  auto state = world.decode(bytes);
  CHECK(state.has_value());
  return *std::move(state);
}

template <class World>
archive::PlaysOut played_out(const World& world, const typename World::Outcome& outcome) {
  if (world.failure(outcome) != nullptr) return archive::PlaysOut::failed;
  return world.satisfied(outcome) ? archive::PlaysOut::yes : archive::PlaysOut::otherwise;
}

}  // namespace sleight::worlds
