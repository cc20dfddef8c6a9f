// Text for people and for TOML: decodes UTF-8, makes hostile bytes harmless on a terminal, and
// writes values that read back to the same bits.
//
// Everything here is a pure function; thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::request {

/// A decoded character: its code point and its length in bytes.
struct CodePoint {
  char32_t value = 0;
  std::size_t bytes = 0;
};

/// Returns the first character of `text`. Returns nothing if it is not well-formed UTF-8. In
/// particular, overlong forms and surrogates are not well-formed. REQUIRES: text is not empty.
std::optional<CodePoint> front_code_point(std::string_view text);

bool is_utf8(std::string_view text);

/// Returns the number of characters (code points). REQUIRES: text is UTF-8.
std::size_t character_count(std::string_view text);

/// Returns `text` as one line, safe for a terminal. Control characters (C0, DEL, C1), characters
/// that reorder or hide text, and line separators become `\u{1b}`; invalid bytes become `\xff`.
/// Longer text is cut to `characters_max` characters and ends in "...".
std::string printable(std::string_view text, std::size_t characters_max);

/// Returns the shortest digits that read back to `value`: 4, 0.1, 1e-6, nan.
std::string plain_number(double value);

/// Returns a TOML float: the shortest digits that read back to `value`, with a '.' or an exponent.
/// REQUIRES: value is finite.
std::string toml_number(double value);

/// Returns a TOML basic string with quotes. REQUIRES: text is UTF-8.
std::string toml_string(std::string_view text);

/// Converts degrees, as people use them, to internal radians. All code uses this function.
double radians_of_degrees(double degrees);

/// Returns the shortest decimal that radians_of_degrees maps exactly to `radians`: 10, not
/// 10.000000000000002. If there is no such decimal, returns the nearest number of degrees.
/// REQUIRES: radians is finite.
double degrees_of_radians(double radians);

}  // namespace sleight::request
