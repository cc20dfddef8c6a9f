// `sleight plot`: pictures of an archive, on the terminal or as SVG or PNG.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "clients/cli/spelling_figures.h"

namespace sleight::cli {

struct PlotOptions {
  std::string path;
  std::string output;                  ///< .svg or .png; empty: draw on the terminal
  std::string what = "trace";          ///< "trace", "paths" or "animations"
  std::optional<std::uint64_t> chain;  ///< none: all, up to six
  std::uint64_t draws = 0;             ///< the first so many; 0: all
  std::uint64_t count = 3;             ///< paths or animations to draw
};

/// Returns the exit code; throws base::Error.
int plot_archive(const PlotOptions& options, const SpellingBoxReader& spelling_box);

}  // namespace sleight::cli
