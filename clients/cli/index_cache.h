// Indices of archives, kept from one command to the next: reading the motions of thousands of
// animations anew takes seconds.
//
// One file an archive, in $XDG_CACHE_HOME/sleight/browse (else ~/.cache/sleight/browse), named by
// the archive's path: what another file claims to be can't get into it. It says which state of the
// archive's file it is of, so that a change by any program is noticed. The files may be deleted at
// any time. All functions do without where the cache can't be read or written.
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

/// The state of a file: another size, place on the disk or time of a change is another state.
struct FileState {
  std::uint64_t size = 0;
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::int64_t modified_ns = 0;
  std::int64_t changed_ns = 0;
  friend bool operator==(const FileState&, const FileState&) = default;
};
/// None where there is no such file.
std::optional<FileState> state_of_file(const std::string& path);

struct KeptIndex {
  browse::Index index{};
  FileState of{};  ///< what it was read from
};

/// What was kept of the archive at this path; it may be of an earlier state of it.
std::optional<KeptIndex> kept_index(const std::string& archive);

/// Keeps it for next time, unless it is too small to be worth it. `of`: the archive's state before
/// it was read.
void keep_index(const std::string& archive, const FileState& of, const browse::Index& index);

}  // namespace sleight::cli
