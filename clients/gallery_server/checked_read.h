// Numbers out of an archive that may be anybody's.
//
// A Source's read has preconditions that an archive's own words can't be trusted for; a server must
// not end by them.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::gallery {

/// Draws read at a time.
inline constexpr std::uint64_t k_rows_at_once = 65'536;

/// Whether there is such a dataset, of numbers or flags, with so many elements.
bool has_numbers(const archive::Source& source, std::string_view group, std::string_view dataset,
                 std::uint64_t elements);

/// Elements first .. first + count - 1 of a dataset that is to have `elements`, as doubles. Throws
/// base::Error(bad_archive) where has_numbers is false. REQUIRES: within the elements.
std::vector<double> checked_numbers(const archive::Source& source, std::string_view group,
                                    std::string_view dataset, std::uint64_t elements,
                                    std::uint64_t first, std::uint64_t count);

/// Draws from the prior that an archive has; 0 where it says so in no usable way.
std::uint64_t prior_draws_of(const archive::Source& source);

}  // namespace sleight::gallery
