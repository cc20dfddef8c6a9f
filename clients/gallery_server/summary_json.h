// Summary of an archive for the page.
#pragma once

#include "clients/gallery_server/snapshot.h"
#include "common/json/value.h"

namespace sleight::gallery {

/// Adds "run", "generation", "world", "kept", "finds", "is_beginning", "keep_max", "chains",
/// "scans", "draws", "as_of" (for people), "warning", "method", "in_proportion" and "satisfied".
void add_facts(json::Value& json, const Snapshot& snapshot);

/// Adds the same keys with empty values, for an archive that has not been read (yet).
void add_no_facts(json::Value& json);

}  // namespace sleight::gallery
