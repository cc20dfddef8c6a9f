// What a mistyped name was probably meant to be.
//
// Pure; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sleight::request {

/// Edits that turn `a` into `b`: a character put in, left out, replaced, or two neighbours swapped
/// (optimal string alignment: no character is edited twice). Counts bytes. Takes time |a| |b|.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The known name that `written` most likely stands for; the earlier of equals; none where nothing
/// is near. Near is: at most 1 + length / 4 edits, upper case and '-' for '_' being free; or one
/// is the other up to a '_', as `sigma` of `sigma_diameters`.
std::optional<std::string> nearest(std::string_view written, std::span<const std::string> known);

}  // namespace sleight::request
