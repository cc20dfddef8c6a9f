// What the page says of an archive before it is opened.
#pragma once

#include "clients/gallery_server/snapshot.h"
#include "common/json/value.h"

namespace sleight::gallery {

/// Adds "run", "generation", "world", "kept", "finds", "keep_max", "chains", "scans", "draws",
/// "as_of" (in words), "warning", "method", "in_proportion" and "satisfied".
void add_facts(json::Value& json, const Snapshot& snapshot);

/// The same of an archive that has not been read (yet): all is empty.
void add_no_facts(json::Value& json);

}  // namespace sleight::gallery
