// The terminal's message if a gallery has nothing to show. The page may not be open yet, and an
// empty page wouldn't show which name was wrong.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.h"

namespace sleight::gallery {

/// Returns one line, or an empty text if something is shown or may soon be shown. `state`: the
/// result of Gallery::state;
/// `paths`: the paths from the command line.
std::string nothing_to_show(const json::Value& state, const std::vector<std::string>& paths);

}  // namespace sleight::gallery
