// Parses a request's target, the part between method and version: "/a/b?c=d%20e".
//
// Ambiguous targets are refused, not repaired, because two readers might see different paths.
// Percent signs are decoded once. "+" means a blank in the query, as in forms and URLSearchParams,
// but stays "+" in the path.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/web/ask.h"

namespace sleight::web {

inline constexpr std::size_t k_target_bytes_max = 2048;

struct Target {
  std::string path{};  ///< as in Ask
  std::vector<Parameter> parameters{};
};

/// Returns none in these cases:
///  - The target is too long or doesn't begin with '/'.
///  - The target contains a backslash, '#', or anything but visible ASCII.
///  - A percent sign isn't followed by two hexadecimal digits.
///  - The target decodes to a control character or to invalid UTF-8.
///  - The path has an encoded backslash or '/', or a decoded segment is "." or "..".
std::optional<Target> parse_target(std::string_view target);

}  // namespace sleight::web
