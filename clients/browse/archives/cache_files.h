// Cache files, so that commands needn't read the same archives again.
//
// There is one file per archive and kind, in $XDG_CACHE_HOME/sleight/browse (default
// ~/.cache/sleight/browse). A cache file's name comes from the archive's path, so an archive can't
// write into another archive's cache. A cache file records the state of the archive's file, so that
// a change by any program is noticed. Cache files may be deleted at any time. All functions work
// without a cache if it can't be read or written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/bytes.h"

namespace sleight::browse {

/// Maximum size of the cache, enforced by deleting the least recently used files.
inline constexpr std::uint64_t k_cache_bytes_max = std::uint64_t{4} << 30;

/// The state of a file. Two states differ if the size, the place on the disk or a time of change
/// differs.
struct FileState {
  std::uint64_t size = 0;
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::int64_t modified_ns = 0;
  std::int64_t changed_ns = 0;
  friend bool operator==(const FileState&, const FileState&) = default;
};
/// Returns nothing if there is no such file.
std::optional<FileState> state_of_file(const std::string& path);

/// Endings by kind of file. None is a suffix of another.
inline constexpr std::string_view k_index_ending = ".index";
inline constexpr std::string_view k_outline_ending = ".outline";

struct CachedBytes {
  FileState of{};  ///< the archive's file when it was read
  std::unique_ptr<std::byte[]> bytes{};
  std::size_t size = 0;
  base::BytesView content() const { return {bytes.get(), size}; }
};

std::optional<CachedBytes> cached(const std::string& archive, std::string_view ending);
/// Stores a cache file, and deletes the least recently used files if the cache is too large.
void keep_cached(const std::string& archive, std::string_view ending, const FileState& of,
                 base::BytesView content);

}  // namespace sleight::browse
