// `sleight plot`: draws pictures of an archive on the terminal or as SVG or PNG. Every world has a
// trace and animations; some worlds have more (world_plots.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/pictures/world_plots.h"

namespace sleight::cli {

struct PlotOptions {
  std::string path;
  std::string output;  ///< .svg or .png file; empty: the terminal
  std::string what{};  ///< one of whats_of; empty: the trace, or animations if there are no draws
  std::optional<std::uint64_t> chain;  ///< none: all, up to six
  std::uint64_t draws = 0;             ///< number of first draws; 0: all
  std::uint64_t count = 3;             ///< animations to draw
  std::vector<std::string> notes{};  ///< `name=value` for an SVG's metadata (clients/plot/notes.h)
};

/// Returns the choices of `what`: first the choices of every world, then choices of single worlds.
std::vector<std::string> whats_of(const pictures::PlotsOfWorlds& worlds);

/// Returns help for the choices: "trace: ...; animations: ...; paths: ... (ball_2d)".
std::string help_of_whats(const pictures::PlotsOfWorlds& worlds);

/// Returns the exit code. Throws base::Error. REQUIRES: `what` is empty or in whats_of().
int plot_archive(const PlotOptions& options, const pictures::PlotsOfWorlds& worlds);

/// `whole`: include details for which a terminal is too small.
pictures::Picture picture_of(const archive::Source& source, const PlotOptions& options, bool whole,
                             const pictures::PlotsOfWorlds& worlds);

}  // namespace sleight::cli
