// Text as the writers need it: always valid UTF-8, measured, shortened, escaped.
//
// Widths are those of DejaVu Sans, in which figures are set; other fonts come close. A character
// outside ASCII counts as a wide one. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sleight::plot {

/// Valid UTF-8 without control characters: each bad byte or control becomes U+FFFD, tabs and line
/// ends become spaces.
std::string printable(std::string_view text);

/// Number of code points. REQUIRES valid UTF-8.
std::size_t length_of(std::string_view text);

/// The first `count` code points. REQUIRES valid UTF-8.
std::string_view first_of(std::string_view text, std::size_t count);

enum class Weight { normal, bold };

/// Width in pixels at a font size. REQUIRES valid UTF-8.
double text_width_px(std::string_view text, double size_px, Weight weight = Weight::normal);

/// The text, or as much of it as fits with an ellipsis at its end. REQUIRES valid UTF-8.
std::string fitted(std::string_view text, double size_px, double width_px,
                   Weight weight = Weight::normal);

/// For XML content and attributes. REQUIRES printable text.
std::string xml_escaped(std::string_view text);

/// Every character beyond ASCII becomes its nearest ASCII letters: σ "sigma", − "-", ± "+-",
/// × "x", other ones "?". REQUIRES valid UTF-8.
std::string to_ascii(std::string_view text);

}  // namespace sleight::plot
