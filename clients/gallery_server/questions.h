// Questions of the page that hold JSON: queries, groups, what is alike.
//
// Functions throw Refused where the question is none, or of another generation than what is shown.
// Thread safety: pure, but for what snapshots read.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "clients/gallery_server/gallery.h"

namespace sleight::gallery {

/// {"query", "archives": [{"id", "generation"}]} -> {"found": [{"id", "entries"}], "errors":
/// [{"id", "column", "message"}]}; columns count characters from 1.
nlohmann::ordered_json found(const Gallery& gallery, const nlohmann::json& ask);

/// {"id", "generation", "entries" or null, "groups", "by"} -> {"approximate", "groups":
/// [{"representative", "members", "mean_m", "greatest_m", "share"}], "share_words"}
nlohmann::ordered_json grouped(const Gallery& gallery, const nlohmann::json& ask);

/// {"id", "generation", "to": [...], "entries" or null} -> {"entries", "distance_m"}, nearest
/// first; of several the distance to the nearest counts.
nlohmann::ordered_json alike(const Gallery& gallery, const nlohmann::json& ask);

}  // namespace sleight::gallery
