// Parses a request's target, the part between method and version: "/a/b?c=d%20e".
//
// Ambiguous targets are refused, not repaired, because two readers might see different paths.
// Percent signs are decoded once. "+" is a blank in the query, as forms and URLSearchParams write
// it, and itself in the path.
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

/// None if the target:
///  - is too long or doesn't begin with '/';
///  - contains anything but visible ASCII, a backslash, or '#';
///  - has a percent sign without two hexadecimal digits;
///  - decodes to a control character or to invalid UTF-8;
///  - has a path that decodes to a backslash, another '/', or a segment "." or "..".
std::optional<Target> parse_target(std::string_view target);

}  // namespace sleight::web
