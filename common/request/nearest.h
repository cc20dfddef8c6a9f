// Suggests the intended name for a mistyped one.
//
// Pure; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sleight::request {

/// Returns the number of edits that turn `a` into `b`: inserting, deleting or replacing a
/// character, or swapping two neighbours (optimal string alignment: no character is edited twice).
/// Counts bytes. Takes time |a| |b|.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Returns the known name nearest to `written`, or nothing if no name is near. If several are
/// equally near, returns the first. A name is near if it differs by at most 1 + length / 4 edits,
/// not counting case and '-' for '_'. A name is also near if one name consists of the other, '_'
/// and more: `sigma` is near `sigma_diameters`.
std::optional<std::string> nearest(std::string_view written, std::span<const std::string> known);

}  // namespace sleight::request
