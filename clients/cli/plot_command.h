// `sleight plot`: pictures of an archive, on the terminal or as SVG or PNG.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/dice_figures.h"
#include "clients/cli/dice_plausibility.h"
#include "clients/cli/spelling_figures.h"

namespace sleight::cli {

struct PlotOptions {
  std::string path;
  std::string output;                  ///< .svg or .png; empty: draw on the terminal
  std::string what = "trace";          ///< "trace", "paths", "animations" or "plausibility"
  std::optional<std::uint64_t> chain;  ///< none: all, up to six
  std::uint64_t draws = 0;             ///< the first so many; 0: all
  std::uint64_t count = 3;             ///< paths or animations to draw
  std::vector<std::string> notes{};  ///< `name=value`, for an SVG's metadata (clients/plot/notes.h)
};

/// What pictures need of requests that only their worlds know.
struct WorldReaders {
  SpellingBoxReader spelling_box;
  DiceSceneReader dice_scene;
  DicePriorReader dice_prior;
};

/// Returns the exit code; throws base::Error.
int plot_archive(const PlotOptions& options, const WorldReaders& readers);

}  // namespace sleight::cli
