// Questions of the page that hold JSON: queries, groups, what is alike.
//
// Functions throw Refused where the question is none, or of another generation than what is shown.
// Thread safety: pure, but for what snapshots read.
#pragma once

#include "clients/gallery_server/gallery.h"
#include "common/json/value.h"

namespace sleight::gallery {

/// {"query", "archives": [{"id", "generation"}]} -> {"found": [{"id", "entries"}], "errors":
/// [{"id", "column", "message"}]}; columns count characters from 1.
json::Value found(const Gallery& gallery, const json::Value& ask);

/// {"id", "generation", "entries" or null, "groups", "by"} -> {"approximate", "groups":
/// [{"representative", "members", "mean_m", "greatest_m", "share"}], "share_words"}
json::Value grouped(const Gallery& gallery, const json::Value& ask);

/// {"id", "generation", "to": [...], "entries" or null} -> {"entries", "distance_m"}, nearest
/// first; of several the distance to the nearest counts.
json::Value alike(const Gallery& gallery, const json::Value& ask);

}  // namespace sleight::gallery
