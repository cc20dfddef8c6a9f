// Verifies attributes, datasets, types and dimensions, without reading values.
#pragma once

#include <string>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive {

/// Returns one sentence per fault. The result is empty if all of these hold: every dataset of
/// docs/ARCHIVE_FORMAT.md has the right type and dimensions; every dimension has its coordinate;
/// every other dataset is one of the world's variables.
std::vector<std::string> check_structure(const Source& source);

}  // namespace sleight::archive
