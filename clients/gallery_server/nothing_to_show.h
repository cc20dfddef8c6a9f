// What a terminal is told where a gallery has nothing to show: a page may not have been opened yet,
// and on an empty one nobody sees what was named wrongly.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.h"

namespace sleight::gallery {

/// One line; empty where something is shown, or may be in a moment. `state`: as Gallery::state says
/// it; `paths`: what the command line named.
std::string nothing_to_show(const json::Value& state, const std::vector<std::string>& paths);

}  // namespace sleight::gallery
