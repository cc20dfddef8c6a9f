// What is answered of one archive, by a server as by a saved gallery.
//
// Functions throw Refused where something isn't there, base::Error where the archive is damaged.
// Thread safety: pure, but for what snapshots read.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "clients/analysis/diagnosis.h"
#include "clients/gallery_server/snapshot.h"
#include "common/json/value.h"

namespace sleight::gallery {

/// Animations in one answer, at most.
inline constexpr std::size_t k_animations_at_once = 32;

/// Features, numbers, the box to look at, blind throws, the request.
json::Value scene_json(const Snapshot& snapshot);
/// What looks the same in all animations (packed.h).
std::string looks(const Snapshot& snapshot);
/// Names and numbers of all animations (packed.h).
std::string table(const Snapshot& snapshot);
/// An animation (packed.h).
std::string one_animation(const Snapshot& snapshot, std::string_view name);
/// Several, the columns of the n-th with "n:" before their names.
std::string several_animations(const Snapshot& snapshot, std::span<const std::string> names);
/// As `sleight diagnose --json` says it. `path`: what it calls the archive.
json::Value diagnosis_json(const Snapshot& snapshot, const std::string& path,
                           const analysis::Rules& rules);

}  // namespace sleight::gallery
