// How people and programs name an archive's animations (browse/index.h): "c0.250" is the one that
// chain 0 found at draw 250; "find.3" is the fourth that a search found (rows of /finds count from
// 0); with the first characters of the run before it, "3f2a9c01:c0.250", one of that run alone.
//
// An id stays the same while a run goes on and its archive grows, and other archives of the run
// have the same animation by it: rows of /animations may shift.
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
  std::uint64_t row = 0;  ///< of /finds or /animations
  std::string text{};     ///< "c0.250"; plain words, whatever the archive holds
};

/// The group that an animation's row is of.
std::string_view group_of(const AnimationId& id);

/// All of an archive: those of chains, then finds. Throws base::Error(bad_archive) where two have
/// one id.
std::vector<AnimationId> animation_ids(const archive::Source& source);

/// Those that are asked for, in that order, each once. Throws base::Error(usage) that names an
/// unknown id, or one of another run, and shows the first few that exist. Ids as they once were,
/// "3.7", are taken, too; where a table may have made that of "3.700", both are named instead.
std::vector<AnimationId> animations_of(const archive::Source& source,
                                       std::span<const std::string> ids);

}  // namespace sleight::browse
