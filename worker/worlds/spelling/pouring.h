// A pouring has balls that drop one after another, and the outcome of the balls dropped so far.
// Search builds pourings (pouring_builder.h), and islands extend them (pouring_stages.h).
// Thread safety: values and pure functions.
#pragma once

#include <cstddef>
#include <vector>

#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {

struct Pouring {
  State state;  ///< balls that have not been dropped yet are inactive
  Outcome outcome;
};

Pouring no_balls(const Spelling& world, std::vector<Vec3> offsets_m);

/// Adds one ball, and simulates the result. REQUIRES: the ball is inactive.
Pouring with_ball(const Spelling& world, const Pouring& pouring, std::size_t ball,
                  const Vec2& drop_m);

}  // namespace sleight::worlds::spelling
