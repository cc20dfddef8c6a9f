// Messages for tests, and equality that looks at bits.
#pragma once

#include <vector>

#include "common/schema/messages.h"

namespace sleight::schema::testing {

/// Doubles whose bits are easily lost on the way: NaN payloads, signalling NaN, infinities, zeros
/// of both signs, subnormals.
std::vector<double> awkward_doubles();

/// A result with every field filled, of as many scans as its unit has.
plan::UnitResult example_result(std::uint32_t scans);

/// One message of every kind and shape, empty and large ones among them.
std::vector<Message> examples();

/// Equal in kind and in every bit of every field.
bool same_bits(const Message& a, const Message& b);

}  // namespace sleight::schema::testing
