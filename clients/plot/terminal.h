// A panel as text for a terminal: braille dots with axes, or plain ASCII.
//
//     │⢢
//     │⠈⡆                                     No line is wider than `columns`, and there are at
//   5 ┤ ⢸⡀                                    most `rows` of them. Ticks, gaps, cut ranges and
//     │  ⢇      ⣀⠤⢄⡀                          thinning are those of the SVG. Bands show as
//     │⡁ ⡹⡀⡁ ⡁ ⡝⠁⡁ ⡉⠢⣅⡀⣁⣀⡥⠴⡓⠒⡓⠒⡥⠤⡥⠤⡥⠤⡥⠤⡥⠤⡥     dotted edges; the legend stands below.
//     │   ⢳  ⢀⠎       ⠈⠁
//   0 ┤    ⠱⠤⠋
//     └┬─────────────┬──────────────┬─────
//      0            50             100
//    ┈┈ target  ── chain 0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "clients/plot/figure.h"

namespace sleight::plot {

struct TerminalOptions {
  std::size_t columns = 80;  ///< fewer than 24 are taken as 24
  std::size_t rows = 24;     ///< fewer than 6 are taken as 6; titles and legend give way first
  bool unicode = true;       ///< otherwise ASCII alone, letters included
  bool color = false;        ///< ANSI escapes with 256 colours
};

/// Lines joined and ended by '\n', without trailing spaces. Pure.
std::string to_terminal(const Panel& panel, const TerminalOptions& options);

/// The options that fit what the file descriptor is connected to: its size (the default where it
/// is no terminal), colours on a terminal that has escapes unless NO_COLOR is set, Unicode where
/// the locale's variables say UTF-8. Reads the environment; changes nothing.
TerminalOptions detect_terminal(int file_descriptor);

/// Whether a locale name such as "en_GB.UTF-8" or "C.utf8" says UTF-8.
bool names_utf8(std::string_view locale);

}  // namespace sleight::plot
