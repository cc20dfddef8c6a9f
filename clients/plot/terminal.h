// A panel as text for a terminal: braille dots with axes, or plain ASCII. No line is wider than
// `columns`, and there are at most `rows` lines. Ticks, gaps, cut ranges and thinning are the same
// as in the SVG. Bands are drawn as dotted edges, and the legend is below the plot:
//
//     │⢢
//     │⠈⡆
//   5 ┤ ⢸⡀
//     │  ⢇      ⣀⠤⢄⡀
//     │⡁ ⡹⡀⡁ ⡁ ⡝⠁⡁ ⡉⠢⣅⡀⣁⣀⡥⠴⡓⠒⡓⠒⡥⠤⡥⠤⡥⠤⡥⠤⡥⠤⡥
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
  std::size_t columns = 80;  ///< values below 24 count as 24
  std::size_t rows = 24;     ///< values below 6 count as 6; titles and legend are omitted first
  bool unicode = true;       ///< false: ASCII only, letters included
  bool color = false;        ///< ANSI escapes with 256 colours
};

/// Returns lines that end in '\n', without trailing spaces. Pure.
std::string to_terminal(const Panel& panel, const TerminalOptions& options);

/// Returns options for the terminal of a file descriptor: its size (default if it isn't a
/// terminal), colours if the terminal has escape codes and NO_COLOR is unset, and Unicode if the
/// locale is UTF-8. Reads the environment.
TerminalOptions detect_terminal(int file_descriptor);

/// Whether a locale name is UTF-8, such as "en_GB.UTF-8" or "C.utf8".
bool names_utf8(std::string_view locale);

}  // namespace sleight::plot
