// States of throws of dice as bytes.
//
// The table's key (u64); the number of overrides (u64) and each: its place (i32, i32), height,
// restitution and friction (f64); then of each die its position, orientation (w, x, y, z), velocity
// and spin (f64).
// Thread safety: pure functions.
#pragma once

#include <optional>

#include "common/base/bytes.h"
#include "worker/worlds/dice/state.h"

namespace sleight::worlds::dice {

base::Bytes encode(const State& state);
/// Refuses another length, a number that is not finite, overrides out of order or off the table or
/// out of their ranges, and orientations that are not of norm 1.
std::optional<State> decode(const WorldParameters& world, base::BytesView bytes);

}  // namespace sleight::worlds::dice
