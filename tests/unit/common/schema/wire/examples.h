// Example messages for tests, and a function that compares messages bit by bit.
#pragma once

#include <cstdint>
#include <vector>

#include "common/schema/messages.h"

namespace sleight::schema::wire::testing {

/// Returns doubles that easily lose bits: NaNs, infinities, signed zeros, subnormals.
std::vector<double> awkward_doubles();

/// Returns a result of `scans` scans. Every transmitted field is filled.
plan::UnitResult example_result(std::uint32_t scans);

/// Returns a delivery of several results. `scans` has the number of scans of each. Every field is
/// filled.
Delivery example_delivery(const std::vector<std::uint32_t>& scans);

/// Returns an assignment of `members` levels of a ladder. The ladder has `members` + 4 levels, and
/// the first assigned level is 3. The assignment has states of all kinds.
Assignment example_assignment(std::uint32_t members);

/// Returns messages of every kind and shape, including empty and large ones.
std::vector<Message> examples();

bool same_bits(const Message& a, const Message& b);

}  // namespace sleight::schema::wire::testing
