// Answers the page's JSON requests: queries, groups and likeness.
//
// Functions throw Refused if the request is invalid, or is for another generation than the one
// shown. Thread safety: pure, except for what snapshots read.
#pragma once

#include "clients/gallery_server/gallery.h"
#include "common/json/value.h"

namespace sleight::gallery {

/// {"query", "archives": [{"id", "generation"}]} -> {"found": [{"id", "entries"}], "errors":
/// [{"id", "column", "message"}]}. Columns count characters from 1.
json::Value found(const Gallery& gallery, const json::Value& ask);

/// {"id", "generation", "entries" or null, "groups", "by"} -> {"approximate", "groups":
/// [{"representative", "members", "mean_m", "greatest_m", "share"}], "share_words"}
json::Value grouped(const Gallery& gallery, const json::Value& ask);

/// {"id", "generation", "to": [...], "entries" or null} -> {"entries", "distance_m"}, nearest
/// first, by the distance to the nearest of "to".
json::Value alike(const Gallery& gallery, const json::Value& ask);

}  // namespace sleight::gallery
