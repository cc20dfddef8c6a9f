// Archives to be browsed together: their animations, and which archives were left out and why.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/browse/archives/index_cache.h"
#include "clients/browse/index.h"
#include "clients/browse/query.h"
#include "clients/browse/reading.h"
#include "common/archive/model.h"

namespace sleight::browse {

struct BrowsedArchive {
  std::string path{};
  browse::Index index{};
  /// Of its animations, those that an archive before it has too: they are left out of its index.
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

/// Opens all, each by itself: one that is damaged costs its own place alone. Tells stderr how
/// reading goes, where it takes long. Throws base::Error with the first one's reason if none is
/// left.
Browsed browse_archives(const std::vector<std::string>& paths);

struct IndexingOptions {
  /// The archive's file as it was before it was opened; none: nothing is kept.
  std::optional<FileState> file{};
  /// Of the run's archive as it was before; null: what is kept of it (index_cache.h).
  const browse::Index* earlier = nullptr;
  /// So many of the first animations are enough, where there are more and they would have to be
  /// read; 0: all are wanted.
  std::uint64_t beginning_max = 0;
  /// Told now and then: animations that were read, of how many.
  std::function<void(std::uint64_t, std::uint64_t)> progress{};
};
/// The index of an archive that is open. What was read before is taken over, and the index is kept
/// for next time unless it is a beginning. Throws base::Error where it has none, or can't be read.
browse::ReadIndex read_index(const archive::Source& source, const std::string& path,
                             const IndexingOptions& options);
/// All of it, telling stderr how it goes.
browse::Index index_of(const archive::Source& source, const std::string& path,
                       const std::optional<FileState>& file);

/// Takes out of each archive's index what an archive before it has too, so that each animation
/// counts once. Part of browse_archives.
void leave_out_twice(Browsed& browsed);

/// An animation of a browsed archive.
struct Picked {
  const BrowsedArchive* archive = nullptr;
  const browse::Entry* entry = nullptr;
};

/// What a command asks for: all of it must hold.
struct QueryOptions {
  std::vector<std::string> select{};  ///< queries
  std::vector<std::string> where{};   ///< likewise; the option's name is all that differs
  std::vector<std::string> in{};      ///< likewise; the option for what is in a box
  std::vector<std::string> not_in{};  ///< queries of which none may hold
};

/// The animations that are meant, in the archives' order. Of several archives those whose scene or
/// numbers a query doesn't fit go to left_out. Throws base::Error(usage) that marks the place in a
/// query that no archive understands.
std::vector<Picked> picked(Browsed& browsed, const QueryOptions& asked);

/// "c0.250"; of several runs "3f2a9c01:c0.250".
std::string name_among(const Browsed& browsed, const browse::AnimationName& name);

/// Lines on stderr: which archives were left out, and which animations there are twice. Asked once,
/// when all that can be left out is.
void say_what_is_missing(const Browsed& browsed);

/// A number as people read it: six digits, "" of NaN.
std::string shown_number(double number);

}  // namespace sleight::browse
