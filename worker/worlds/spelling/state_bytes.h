// States of spelling animations as bytes.
//
// Doubles: the offsets of all partition vertices (x, y, z each), then for each ball 1 or 0 for
// active, then for each ball its drop place (x, y).
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <vector>

#include "common/base/bytes.h"
#include "worker/worlds/spelling/proposals.h"

namespace sleight::worlds::spelling {

/// All numbers of a state, in that order.
std::vector<double> values_of(const State& state);
base::Bytes encode(const State& state);
/// Refuses another length, an offset or place that is not finite, and any activity but 0 and 1.
std::optional<State> decode(const Prior& prior, base::BytesView bytes);

}  // namespace sleight::worlds::spelling
