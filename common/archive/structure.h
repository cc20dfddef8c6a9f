// The first half of verify: attributes, datasets, types and dimensions, without any value.
#pragma once

#include <string>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive {

/// One sentence for each fault; empty when every dataset of docs/ARCHIVE_FORMAT.md is there with
/// its type and dimensions, every dimension has its coordinate, and all else is a world's variable.
std::vector<std::string> check_structure(const Source& source);

}  // namespace sleight::archive
