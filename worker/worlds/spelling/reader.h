// How spelling archives name things, and how states become bytes.
//
// A state's bytes are doubles: the offsets of all partition vertices (x, y, z each), then for each
// ball 1 or 0 for active, then for each ball its drop place (x, y).
// Likeness distance of two animations: the share of designated bins that are not filled by the same
// ball in both.
#pragma once

#include <memory>
#include <optional>

#include "common/archive/world_layout.h"
#include "common/base/bytes.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {

base::Bytes encode(const State& state);
/// Refuses another length, an offset or place that is not finite, and any activity but 0 and 1.
std::optional<State> decode(const Prior& prior, base::BytesView bytes);

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);

}  // namespace sleight::worlds::spelling
