// The byte encoding of throws of dice.
//
// The bytes contain the table's key (u64) and the number of overrides (u64), then each override's
// index (i32, i32), height, restitution and friction (f64). Then each die has its position,
// orientation (w, x, y, z), velocity and spin (f64).
// Thread safety: pure functions.
#pragma once

#include <optional>

#include "common/base/bytes.h"
#include "worker/worlds/dice/state.h"

namespace sleight::worlds::dice {

base::Bytes encode(const State& state);
/// Refuses a wrong length, numbers that aren't finite, overrides that are out of order, off the
/// table or out of range, and orientations whose norm isn't 1.
std::optional<State> decode(const WorldParameters& world, base::BytesView bytes);

}  // namespace sleight::worlds::dice
