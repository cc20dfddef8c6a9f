// The byte encoding of spelling states.
//
// The bytes contain doubles. First come all partition vertices' offsets (x, y, z each). Then each
// ball has 1 if it is active, or 0. Then each ball has its drop place (x, y).
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <vector>

#include "common/base/bytes.h"
#include "worker/worlds/spelling/proposals.h"

namespace sleight::worlds::spelling {

/// Returns all numbers of a state, in the order of the bytes.
std::vector<double> values_of(const State& state);
base::Bytes encode(const State& state);
/// Refuses a wrong length, an offset or place that isn't finite, and any activity except 0 and 1.
std::optional<State> decode(const Prior& prior, base::BytesView bytes);

}  // namespace sleight::worlds::spelling
