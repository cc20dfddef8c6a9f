// Slow, plain answers to queries, and random queries. They test the fast answers.
//
// Certain times decide whether a body's centre is in a box during a piece: the piece's ends, the
// times at which a coordinate crosses a bound, and the middles between successive times. If the
// centre is in the box at all, it is in the box at one of these times. The slow answer tests all
// these times of all pieces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "clients/browse/index.h"
#include "clients/browse/query.h"
#include "common/random/stream.h"

namespace sleight::browse::testing {

/// Returns the first time in the box, or nothing if the body is never in the box. Each side of the
/// box first moves outwards by `margin_m`, or inwards if `margin_m` is negative.
std::optional<double> slow_first_inside(std::span<const Piece> pieces, const Box& box,
                                        const Stretch& when, double margin_m = 0);

bool slow_is_met(const Condition& condition, const Entry& entry, double margin_m = 0);

/// Returns whether rounding errors may decide if this animation meets the condition. Then both
/// answers are valid.
bool is_close_call(const Condition& condition, const Entry& entry);

/// Returns the text that a person would type for the condition. Returns nothing for hits of a goal,
/// which have no text.
std::optional<std::string> text_of(const Condition& condition, const Index& index);

/// Returns a random condition on animations of the index. The condition is at most `depth` deep.
/// About half of the conditions are met. REQUIRES: at least one entry.
Condition random_condition(const Index& index, random::Stream& stream, int depth);

}  // namespace sleight::browse::testing
