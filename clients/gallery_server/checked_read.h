// Reads numbers from an untrusted archive.
//
// Source::read() has preconditions that a damaged or hostile archive may violate; a server must
// survive this.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::gallery {

/// Draws read at a time.
inline constexpr std::uint64_t k_rows_at_once = 65'536;

/// Null if the dataset doesn't exist.
const archive::DatasetSpec* dataset_of(const archive::Source& source, std::string_view group,
                                       std::string_view dataset);

/// Whether the dataset exists, contains numbers or flags, and has this number of elements.
bool has_numbers(const archive::Source& source, std::string_view group, std::string_view dataset,
                 std::uint64_t elements);

/// Returns the elements first .. first + count - 1 of a dataset with `elements` elements, as
/// doubles. Throws base::Error(bad_archive) if has_numbers() is false. REQUIRES: first + count <=
/// elements.
std::vector<double> checked_numbers(const archive::Source& source, std::string_view group,
                                    std::string_view dataset, std::uint64_t elements,
                                    std::uint64_t first, std::uint64_t count);

/// Number of prior draws in an archive; 0 if there is no usable number.
std::uint64_t prior_draws_of(const archive::Source& source);

}  // namespace sleight::gallery
