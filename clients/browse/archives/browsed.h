// Opens archives to browse them together, and reports which archives were left out and why.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/browse/archives/index_cache.h"
#include "clients/browse/index.h"
#include "clients/browse/reading.h"
#include "common/archive/model.h"

namespace sleight::browse {

struct BrowsedArchive {
  std::string path{};
  browse::Index index{};
  /// Number of animations left out of this index because an earlier archive has them.
  std::size_t twice = 0;
};

struct LeftOut {
  std::string path{};
  std::string reason{};
};

struct Browsed {
  std::vector<BrowsedArchive> archives{};
  std::vector<LeftOut> left_out{};
  std::size_t animations() const;
};

/// Opens all archives independently, so a damaged archive affects only itself. Reports slow reading
/// on stderr. Throws base::Error with the first archive's reason if no archive can be opened.
Browsed browse_archives(const std::vector<std::string>& paths);

struct IndexingOptions {
  /// State of the archive's file before it was opened. None: don't cache the index.
  std::optional<FileState> file{};
  /// Earlier index of the run's archive. Null: use the cached index (index_cache.h).
  const browse::Index* earlier = nullptr;
  /// If more than this many animations would have to be read, read only this many. 0: read all.
  std::uint64_t beginning_max = 0;
  /// Progress callback: animations read, animations in total.
  std::function<void(std::uint64_t, std::uint64_t)> progress{};
};
/// Returns an open archive's index. Reuses entries of earlier indices, and caches the index unless
/// it is incomplete. Throws base::Error if the archive has no index or can't be read.
browse::ReadIndex read_index(const archive::Source& source, const std::string& path,
                             const IndexingOptions& options);
/// Returns the complete index, and reports progress on stderr.
browse::Index index_of(const archive::Source& source, const std::string& path,
                       const std::optional<FileState>& file);

/// Removes from each archive's index the animations that an earlier archive also has, so that each
/// animation counts once. Part of browse_archives.
void leave_out_twice(Browsed& browsed);

struct Picked {
  const BrowsedArchive* archive = nullptr;
  const browse::Entry* entry = nullptr;
};

/// A command's conditions, which must all hold.
struct QueryOptions {
  std::vector<std::string> select{};  ///< queries
  std::vector<std::string> where{};   ///< queries too; only the option's name differs
  std::vector<std::string> in{};      ///< queries too; the option for boxes
  std::vector<std::string> not_in{};  ///< queries that must not hold
};

/// Returns the matching animations in the archives' order. Archives whose scene or numbers don't
/// fit a query are moved to left_out. Throws base::Error(usage) with the position in the query if
/// no archive fits.
std::vector<Picked> picked(Browsed& browsed, const QueryOptions& asked);

/// Returns "c0.250", or "3f2a9c01:c0.250" if there are several runs.
std::string name_among(const Browsed& browsed, const browse::AnimationName& name);

/// Prints to stderr which archives were left out and how many duplicate animations there are.
/// REQUIRES: called once, after the last step that can leave out archives.
void say_what_is_missing(const Browsed& browsed);

/// Formats a number with six digits. NaN becomes "".
std::string shown_number(double number);

}  // namespace sleight::browse
