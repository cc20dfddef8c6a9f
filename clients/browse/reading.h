// Reads an index from an archive, reusing earlier entries while a run continues. Thread safety: as
// the source's.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "clients/browse/index.h"
#include "common/archive/model.h"
#include "common/base/result.h"

namespace sleight::browse {

/// Arrays with more elements per animation, such as HI's vertex offsets, are left out of the index.
inline constexpr std::size_t k_number_elements_max = 64;

/// Maximum amounts read from an archive, because a small file may claim any number. An index takes
/// about 120 bytes per segment, 60 per body of an animation and 8 per number of an animation.
inline constexpr double k_browsed_segments_max = 50e6;
inline constexpr double k_browsed_bodies_max = 5e6;
inline constexpr double k_browsed_numbers_max = 200e6;

struct ReadingOptions {
  /// Index of an earlier archive of the run; null: none. The earlier index's scene isn't used.
  /// Entries are reused for animations with the same name and numbers. If the archive has the same
  /// digest, nothing is reused, because another program can change an archive without changing the
  /// stored digest.
  const Index* earlier = nullptr;
  /// Index of exactly this file, which hasn't changed since. The index's entries are moved out
  /// without reading the file. If the file changed anyway, treat the index as `earlier`.
  Index* of_this_file = nullptr;
  /// If more than this many animations would have to be read and no earlier index is usable, read
  /// only this many. 0: read all.
  std::uint64_t beginning_max = 0;
  /// Progress callback: animations read, animations in total.
  std::function<void(std::uint64_t, std::uint64_t)> progress{};
};

struct ReadIndex {
  Index index{};
  std::uint64_t taken_over = 0;  ///< entries reused from the earlier index
  bool is_beginning = false;     ///< the archive has more animations
};

/// Reads the animations of /animations, then those of /finds. Returns an error text if the scene
/// description is invalid. Throws base::Error if the archive can't be read or an animation is
/// invalid.
base::Result<ReadIndex, std::string> read_index(const archive::Source& source,
                                                const ReadingOptions& options = {});

}  // namespace sleight::browse
