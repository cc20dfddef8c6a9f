// Ids of an archive's animations (browse/index.h) for people and programs. "c0.250" is the
// animation that chain 0 found at draw 250. "find.3" is the fourth find of a search (rows of /finds
// count from 0). A prefix of the run id restricts the id to that run: "3f2a9c01:c0.250".
//
// An id stays the same while a run continues, and it names the same animation in all archives of
// the run. Rows of /animations may shift.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/model.h"

namespace sleight::browse {

struct AnimationId {
  bool is_find = false;
  std::uint64_t row = 0;  ///< in /finds or /animations
  std::string text{};     ///< such as "c0.250"; always plain text
};

/// Returns the archive group that contains the animation's row.
std::string_view group_of(const AnimationId& id);

/// Returns all ids of an archive: animations of chains, then finds. Throws base::Error(bad_archive)
/// if two animations have the same id.
std::vector<AnimationId> animation_ids(const archive::Source& source);

/// Returns the requested ids in the given order, without duplicates. Throws base::Error(usage) for
/// an unknown id or an id of another run; the message lists the first few ids. Old ids such as
/// "3.7" are accepted. If a spreadsheet may have turned "3.700" into "3.7", the error lists the
/// possible ids.
std::vector<AnimationId> animations_of(const archive::Source& source,
                                       std::span<const std::string> ids);

}  // namespace sleight::browse
