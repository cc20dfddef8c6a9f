// Answers about one archive, for servers and saved galleries.
//
// Functions throw Refused if something doesn't exist, and base::Error if the archive is damaged.
// Thread safety: pure, except for what snapshots read.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "clients/analysis/diagnosis.h"
#include "clients/gallery_server/snapshot.h"
#include "common/json/value.h"

namespace sleight::gallery {

/// Maximum number of animations per answer.
inline constexpr std::size_t k_animations_at_once = 32;

/// Returns the scene's features, the numbers, the view, log_prior of blind throws, and the request.
json::Value scene_json(const Snapshot& snapshot);
/// The looks that all animations share (packed.h).
std::string looks(const Snapshot& snapshot);
/// Names and numbers of all animations (packed.h).
std::string table(const Snapshot& snapshot);
/// One animation (packed.h).
std::string one_animation(const Snapshot& snapshot, std::string_view name);
/// Several animations. Names of the n-th animation's columns have the prefix "n:".
std::string several_animations(const Snapshot& snapshot, std::span<const std::string> names);
/// The output of `sleight diagnose --json`. `path`: the archive's name in the output.
json::Value diagnosis_json(const Snapshot& snapshot, const std::string& path,
                           const analysis::Rules& rules);

}  // namespace sleight::gallery
