// Checks whether the contents reported by a reader process are valid. hdf5/inspect.h makes the same
// checks in the reader process, but a hostile file may have taken over that process.
//
// Users of a Source rely on these properties: names are plain words and unique in their place, the
// root group comes first, each dimension has a dataset of its name, sizes are within limits.h and
// don't overflow, and texts contain nothing that could control a terminal.
//
// Thread safety: pure.
#pragma once

#include <string>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive::remote {

/// Returns a description of the fault that names the object. The text is safe to display. Empty: no
/// fault.
std::string fault_of_contents(const std::vector<Group>& groups);

/// Returns whether the dataset may have this text. Only the request's text may have several lines.
bool is_text_for(std::string_view group, std::string_view dataset, std::string_view text);

/// Truncates `text` for display and replaces everything that could control a terminal.
std::string shown_text(std::string_view text);

}  // namespace sleight::archive::remote
