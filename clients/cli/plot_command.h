// `sleight plot`: pictures of an archive, on the terminal or as SVG or PNG.
//
// A trace and the animations of any world; and what single worlds have (world_plots.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/pictures/world_plots.h"

namespace sleight::cli {

struct PlotOptions {
  std::string path;
  std::string output;                  ///< .svg or .png; empty: draw on the terminal
  std::string what{};                  ///< one of whats_of; empty: the trace, or without draws
                                       ///< the animations
  std::optional<std::uint64_t> chain;  ///< none: all, up to six
  std::uint64_t draws = 0;             ///< the first so many; 0: all
  std::uint64_t count = 3;             ///< animations to draw
  std::vector<std::string> notes{};  ///< `name=value`, for an SVG's metadata (clients/plot/notes.h)
};

/// What can be asked for: of every world, then of single ones.
std::vector<std::string> whats_of(const pictures::PlotsOfWorlds& worlds);

/// What each of these is, for the help: "trace: ...; animations: ...; paths: ... (ball_2d)".
std::string help_of_whats(const pictures::PlotsOfWorlds& worlds);

/// Returns the exit code; throws base::Error. REQUIRES: one of whats_of is asked for.
int plot_archive(const PlotOptions& options, const pictures::PlotsOfWorlds& worlds);

/// What it draws, as a value. `whole`: for a file, with more than a terminal has room for.
pictures::Picture picture_of(const archive::Source& source, const PlotOptions& options, bool whole,
                             const pictures::PlotsOfWorlds& worlds);

}  // namespace sleight::cli
