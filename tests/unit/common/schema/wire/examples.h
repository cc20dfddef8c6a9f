// Example messages for tests, and their bitwise comparison.
#pragma once

#include <cstdint>
#include <vector>

#include "common/schema/messages.h"

namespace sleight::schema::wire::testing {

/// Returns doubles whose bits are easily lost: NaNs, infinities, signed zeros, subnormals.
std::vector<double> awkward_doubles();

/// Returns a result of `scans` scans with every transmitted field filled.
plan::UnitResult example_result(std::uint32_t scans);

/// Returns a delivery of results with these numbers of scans. Every field is filled.
Delivery example_delivery(const std::vector<std::uint32_t>& scans);

/// Returns an assignment of a part of a ladder, starting at level 3 of `members` + 4 levels, with
/// states of all kinds.
Assignment example_assignment(std::uint32_t members);

/// Returns messages of every kind and shape, including empty and large ones.
std::vector<Message> examples();

bool same_bits(const Message& a, const Message& b);

}  // namespace sleight::schema::wire::testing
