// Whether what a reader process says of an archive's contents can be: what hdf5/inspect.h makes
// sure of in a file, judged anew from its answer, since a hostile file may have taken the process
// over.
//
// Whoever reads a Source relies on these: names are plain words and unique in their place, the root
// group comes first, every dimension is named by a dataset of its own, sizes stay in their limits
// (limits.h) and don't overflow, and texts hold nothing that could steer a terminal.
//
// Thread safety: pure.
#pragma once

#include <string>
#include <vector>

#include "common/archive/model.h"

namespace sleight::archive::remote {

/// Empty where they can be; else what is wrong, naming the object, fit to be shown.
std::string fault_of_contents(const std::vector<Group>& groups);

/// Whether a dataset may hold such a text: only the request has lines.
bool is_text_for(std::string_view group, std::string_view dataset, std::string_view text);

/// `text` without what could steer a terminal, cut to a length that can be shown.
std::string shown_text(std::string_view text);

}  // namespace sleight::archive::remote
