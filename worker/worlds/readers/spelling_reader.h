// The reader of spelling archives.
//
// Likeness distance of two animations: the share of designated bins that don't have the same ball
// in both animations.
// Thread safety: readers may be used from several threads.
#pragma once

#include <memory>

#include "common/archive/world_layout.h"
#include "worker/worlds/spelling/parameters.h"

namespace sleight::worlds::spelling {

std::unique_ptr<archive::StateReader> make_state_reader(const Parameters& parameters);

}  // namespace sleight::worlds::spelling
