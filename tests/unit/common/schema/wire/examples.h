// Messages for tests, and equality that looks at bits.
#pragma once

#include <cstdint>
#include <vector>

#include "common/schema/messages.h"

namespace sleight::schema::wire::testing {

/// Doubles whose bits are easily lost on the way: NaN payloads, signalling NaN, infinities, zeros
/// of both signs, subnormals.
std::vector<double> awkward_doubles();

/// A result with every field filled that travels, of as many scans as its unit has.
plan::UnitResult example_result(std::uint32_t scans);

/// A delivery of results with so many scans, every field filled.
Delivery example_delivery(const std::vector<std::uint32_t>& scans);

/// A part of a ladder, from level 3 of four more levels than it has members: states of all sorts.
Assignment example_assignment(std::uint32_t members);

/// One message of every kind and shape, empty and large ones among them.
std::vector<Message> examples();

/// Equal in kind and in every bit of every field.
bool same_bits(const Message& a, const Message& b);

}  // namespace sleight::schema::wire::testing
