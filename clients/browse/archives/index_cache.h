// What was read of archives' animations, kept from one command to the next (cache_files.h): reading
// the motions of thousands anew takes seconds.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "clients/browse/archives/cache_files.h"
#include "clients/browse/index.h"
#include "clients/browse/outline.h"

namespace sleight::browse {

/// Smaller ones are read as fast from the archive.
inline constexpr std::size_t k_pieces_worth_keeping = 20'000;

struct KeptIndex {
  browse::Index index{};
  FileState of{};  ///< what it was read from
};

/// What was kept of the archive at this path; it may be of an earlier state of it.
std::optional<KeptIndex> kept_index(const std::string& archive);

/// Keeps it for next time, unless it is too small to be worth it. `of`: the archive's state before
/// it was read.
void keep_index(const std::string& archive, const FileState& of, const browse::Index& index);

/// What was kept of this very state of the archive by this very build of the program.
std::optional<browse::Outline> kept_outline(const std::string& archive, const FileState& of);

/// As keep_index. `groups`: of all entries, as an outline has them.
void keep_outline(const std::string& archive, const FileState& of, const browse::Index& index,
                  const browse::Groups& groups);

}  // namespace sleight::browse
