// Suggests the intended name for a mistyped one.
//
// Pure; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sleight::request {

/// Returns the minimum number of edits that turn `a` into `b`. An edit inserts, deletes or replaces
/// a character, or swaps two neighbours. No character is edited twice (optimal string alignment).
/// Counts bytes. Takes time |a| |b|.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Returns the known name nearest to `written`, or nothing if no name is near. If several are
/// equally near, returns the first. A name is near if at most 1 + length / 4 edits turn `written`
/// into it. Differences of case, and between '-' and '_', don't count. A name is also near if one
/// name consists of the other, '_' and more: `sigma` is near `sigma_diameters`.
std::optional<std::string> nearest(std::string_view written, std::span<const std::string> known);

}  // namespace sleight::request
