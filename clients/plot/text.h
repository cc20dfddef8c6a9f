// Prepares text for the writers: makes UTF-8 valid, measures, shortens and escapes.
//
// Widths are measured for DejaVu Sans, the font of figures; other fonts are similar. Characters
// outside ASCII count as wide. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sleight::plot {

/// Returns valid UTF-8 without control characters: bad bytes and controls become U+FFFD, tabs and
/// line breaks become spaces.
std::string printable(std::string_view text);

/// Counts code points. REQUIRES valid UTF-8.
std::size_t length_of(std::string_view text);

/// Returns the first `count` code points. REQUIRES valid UTF-8.
std::string_view first_of(std::string_view text, std::size_t count);

enum class Weight { normal, bold };

/// Returns the width in pixels at a font size. REQUIRES valid UTF-8.
double text_width_px(std::string_view text, double size_px, Weight weight = Weight::normal);

/// Returns the text, cut with an ellipsis if too long. REQUIRES valid UTF-8.
std::string fitted(std::string_view text, double size_px, double width_px,
                   Weight weight = Weight::normal);

/// Escapes XML content and attributes. REQUIRES printable text.
std::string xml_escaped(std::string_view text);

/// Replaces characters outside ASCII: σ by "sigma", − by "-", ± by "+-", × by "x", others by "?".
/// REQUIRES valid UTF-8.
std::string to_ascii(std::string_view text);

}  // namespace sleight::plot
