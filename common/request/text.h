// Text as people read it and as TOML writes it: decoding UTF-8, making hostile bytes harmless on a
// terminal, and writing values so that they read back to the same bits.
//
// Everything here is a pure function; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::request {

/// One decoded character: its code point, and the bytes it took.
struct CodePoint {
  char32_t value = 0;
  std::size_t bytes = 0;
};

/// The character at the front of `text`; none if it is not well-formed UTF-8 (overlong forms and
/// surrogates are not). REQUIRES: text is not empty.
std::optional<CodePoint> front_code_point(std::string_view text);

bool is_utf8(std::string_view text);

/// Characters (code points) in `text`. REQUIRES: text is UTF-8.
std::size_t character_count(std::string_view text);

/// `text` on one line, fit for a terminal: control characters (C0, DEL, C1), marks that reorder or
/// hide text, and line separators become `\u{1b}`; bytes that are not UTF-8 become `\xff`. After
/// `characters_max` characters it is cut and ends in "...".
std::string printable(std::string_view text, std::size_t characters_max);

/// The shortest digits that read back to `value`, as people write them: 4, 0.1, 1e-6, nan.
std::string plain_number(double value);

/// A TOML float: the shortest digits that read back to `value`, always with a '.' or an exponent.
/// REQUIRES: value is finite.
std::string toml_number(double value);

/// A TOML basic string, quotes included. REQUIRES: text is UTF-8.
std::string toml_string(std::string_view text);

/// Degrees for people, radians inside: how the two are converted everywhere.
double radians_of_degrees(double degrees);

/// The shortest decimal that radians_of_degrees takes to exactly `radians`: 10, not
/// 10.000000000000002. Where none does, the nearest number of degrees. REQUIRES: radians is finite.
double degrees_of_radians(double radians);

}  // namespace sleight::request
