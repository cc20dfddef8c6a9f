// What the page says of an archive before it is opened.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "clients/gallery_server/snapshot.h"

namespace sleight::gallery {

/// Adds "run", "generation", "world", "kept", "finds", "keep_max", "chains", "scans", "draws",
/// "as_of" (in words), "warning", "method", "in_proportion" and "satisfied".
void add_facts(nlohmann::ordered_json& json, const Snapshot& snapshot);

/// The same of an archive that has not been read (yet): all is empty.
void add_no_facts(nlohmann::ordered_json& json);

}  // namespace sleight::gallery
