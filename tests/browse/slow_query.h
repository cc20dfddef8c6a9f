// Queries answered slowly and plainly, and random queries: what the fast ones are compared with.
//
// A body's centre is in a box at some moment of a piece exactly if it is there at one of these: the
// piece's ends, the moments at which a coordinate passes a bound, and the middles between any two
// that follow one another. So all of them are tried, of all pieces of the body.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "clients/browse/index.h"
#include "clients/browse/query.h"
#include "common/random/stream.h"

namespace sleight::browse::testing {

/// The first moment in the box, nothing if there is none. `margin_m`: the box is wider by so much
/// on each side, or narrower where it is negative.
std::optional<double> slow_first_inside(std::span<const Piece> pieces, const Box& box,
                                        const Stretch& when, double margin_m = 0);

/// True if the animation is meant.
bool slow_is_met(const Condition& condition, const Entry& entry, double margin_m = 0);

/// Whether any comparison of this condition lies within rounding of its bound in this animation:
/// the answer is then either's.
bool is_close_call(const Condition& condition, const Entry& entry);

/// What a person would type for it; none where that can't be said: hits of a goal.
std::optional<std::string> text_of(const Condition& condition, const Index& index);

/// A random condition on animations of the index, at most `depth` deep, about as often met as not.
/// REQUIRES: an entry at least.
Condition random_condition(const Index& index, random::Stream& stream, int depth);

}  // namespace sleight::browse::testing
