// Caches archives' indices from one command to the next, because reading the motions of thousands
// of animations takes seconds.
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

#include "clients/browse/index.h"
#include "clients/browse/outline.h"
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

/// An index with fewer pieces isn't cached, because reading it from the archive is as fast.
inline constexpr std::size_t k_pieces_worth_keeping = 20'000;

struct KeptIndex {
  browse::Index index{};
  FileState of{};  ///< the archive's file when it was read
};

/// Returns the cached index of the archive at this path. The index may be of an earlier state of
/// the file.
std::optional<KeptIndex> kept_index(const std::string& archive);

/// Caches an index unless it is too small. `of`: the file's state before it was read.
void keep_index(const std::string& archive, const FileState& of, const browse::Index& index);

/// Returns the cached outline of exactly this state of the file, made by this build of the program.
std::optional<browse::Outline> kept_outline(const std::string& archive, const FileState& of);

/// Caches an outline, like keep_index. `groups`: of all entries (outline.h).
void keep_outline(const std::string& archive, const FileState& of, const browse::Index& index,
                  const browse::Groups& groups);

}  // namespace sleight::browse
