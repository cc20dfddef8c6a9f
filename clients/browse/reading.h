// An index out of an archive, and how it grows while a run goes on.
//
// Thread safety: as the source's.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "clients/browse/index.h"
#include "common/archive/model.h"
#include "common/base/result.h"

namespace sleight::browse {

/// Numbers of an animation with more elements than this are left out, as HI's offsets of vertices.
inline constexpr std::size_t k_number_elements_max = 64;

/// What of an archive is read, at most: a small file may claim any number. An index takes about 120
/// bytes for a segment, 60 for a body of an animation, 8 for a number of one.
inline constexpr double k_browsed_segments_max = 50e6;
inline constexpr double k_browsed_bodies_max = 5e6;
inline constexpr double k_browsed_numbers_max = 200e6;

struct ReadingOptions {
  /// An index of an earlier archive of the run; null: none. Its scene is not asked for. Entries are
  /// taken over where the archive's animations are called so and have the same numbers. Of an
  /// archive with the same digest nothing is: it may have been changed by other programs, which
  /// leave the digest as it was.
  const Index* earlier = nullptr;
  /// An index of this very file, which nobody has written since: its entries are moved out of it,
  /// unread. Where the archive is another all the same, it is one of an earlier archive.
  Index* of_this_file = nullptr;
  /// So many of the first animations are enough, where there are more and no earlier index is of
  /// use; 0: all are wanted.
  std::uint64_t beginning_max = 0;
  /// Told now and then: animations that were read, of how many.
  std::function<void(std::uint64_t, std::uint64_t)> progress{};
};

struct ReadIndex {
  Index index{};
  std::uint64_t taken_over = 0;  ///< entries that are the earlier index's
  bool is_beginning = false;     ///< there are more animations
};

/// The animations of /animations, then those of /finds; or what is wrong with its scene. Throws
/// base::Error where it can't be read, or an animation is none.
base::Result<ReadIndex, std::string> read_index(const archive::Source& source,
                                                const ReadingOptions& options = {});

}  // namespace sleight::browse
