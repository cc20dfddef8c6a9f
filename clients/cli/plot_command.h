// `sleight plot`: pictures of an archive, on the terminal or as SVG or PNG.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sleight::cli {

struct PlotOptions {
  std::string path;
  std::string output;                  ///< .svg or .png; empty: draw on the terminal
  std::string what = "trace";          ///< "trace" or "paths"
  std::optional<std::uint64_t> chain;  ///< none: all, up to six
  std::uint64_t draws = 0;             ///< the first so many; 0: all
  std::uint64_t count = 3;             ///< paths to draw
};

/// Returns the exit code; throws base::Error.
int plot_archive(const PlotOptions& options);

}  // namespace sleight::cli
