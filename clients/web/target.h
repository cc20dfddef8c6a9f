// A request's target, taken apart: what stands between method and version, as "/a/b?c=d%20e".
//
// It is refused rather than mended: whatever two readers might take for different paths is none.
// Percent signs are decoded once. Of "+" the query's is a blank, as forms and URLSearchParams write
// it, the path's is itself.
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

/// None where it is too long or doesn't begin with '/'; holds other than visible ASCII, a
/// backslash, or '#'; has a percent sign without two hexadecimal digits; or decodes to a control
/// character, to what is not UTF-8, or in the path to a backslash, another '/', or a segment "." or
/// "..".
std::optional<Target> parse_target(std::string_view target);

}  // namespace sleight::web
