// Files in which programs keep what reading an archive has cost them, from one command to the next.
//
// One file an archive and kind, in $XDG_CACHE_HOME/sleight/browse (else ~/.cache/sleight/browse),
// named by the archive's path: what another file claims to be can't get into it. It says which
// state of the archive's file it is of, so that a change by any program is noticed. The files may
// be deleted at any time. All functions do without where the cache can't be read or written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/bytes.h"

namespace sleight::browse {

/// Beyond this the files that were used longest ago are deleted.
inline constexpr std::uint64_t k_cache_bytes_max = std::uint64_t{4} << 30;

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

/// The kinds of files; no ending is the end of another.
inline constexpr std::string_view k_index_ending = ".index";
inline constexpr std::string_view k_outline_ending = ".outline";

/// What a file of the cache has.
struct CachedBytes {
  FileState of{};  ///< the archive's, when it was read
  std::unique_ptr<std::byte[]> bytes{};
  std::size_t size = 0;
  base::BytesView content() const { return {bytes.get(), size}; }
};

std::optional<CachedBytes> cached(const std::string& archive, std::string_view ending);
/// Where there are too many, those that were used longest ago go.
void keep_cached(const std::string& archive, std::string_view ending, const FileState& of,
                 base::BytesView content);

}  // namespace sleight::browse
