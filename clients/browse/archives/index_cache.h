// Caches archives' indices from one command to the next (cache_files.h), because reading the
// motions of thousands of animations takes seconds.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "clients/browse/archives/cache_files.h"
#include "clients/browse/index.h"
#include "clients/browse/outline.h"

namespace sleight::browse {

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
