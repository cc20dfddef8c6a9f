// Indices of archives, kept from one command to the next: reading the motions of thousands of
// animations anew takes seconds.
//
// One file an archive, in $XDG_CACHE_HOME/sleight/browse (else ~/.cache/sleight/browse), named by
// the archive's path: what another file claims to be can't get into it. The files may be deleted
// at any time. All functions do without where the cache can't be read or written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "clients/browse/index.h"

namespace sleight::cli {

/// Beyond this the indices that were used longest ago are deleted.
inline constexpr std::uint64_t k_cache_bytes_max = std::uint64_t{4} << 30;
/// Smaller ones are read as fast from the archive.
inline constexpr std::size_t k_pieces_worth_keeping = 20'000;

/// What was kept of the archive at this path; it may be of an earlier state of it.
std::optional<browse::Index> kept_index(const std::string& archive);

/// Keeps it for next time, unless it is too small to be worth it.
void keep_index(const std::string& archive, const browse::Index& index);

}  // namespace sleight::cli
