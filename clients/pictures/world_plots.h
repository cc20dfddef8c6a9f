// Plots specific to one world.
//
// `sleight plot` draws a trace and animations of any world from what all archives contain
// (plot_command.h, animation_figures.h). A world with further plots, or with its own trace, defines
// a WorldPlots in clients/world_plots; a program's main lists them. The list determines the values
// and help of `--what` and the errors about unavailable pictures, so no command contains a world's
// name.
// Thread safety: const functions may be called from several threads with separate sources.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/plot/figure.h"
#include "common/archive/model.h"

namespace sleight::pictures {

/// Kinds available for every world.
inline constexpr std::string_view k_trace = "trace";
inline constexpr std::string_view k_drawn_animations = "animations";

/// Which part of an archive to draw.
struct DrawnPart {
  std::optional<std::uint64_t> chain{};  ///< none: all that fit into the picture
  std::uint64_t draws = 0;               ///< number of first draws; 0: all
  std::uint64_t count = 3;               ///< number of animations, for pictures of single ones
};

/// A picture with explanatory lines, each with its line break.
struct Picture {
  plot::Figure figure{};
  std::string words{};
};

class WorldPlots {
 public:
  /// A value of `--what`.
  struct Kind {
    std::string what{};
    std::string help{};  ///< short description; unused for k_trace
  };

  virtual ~WorldPlots() = default;
  /// Returns the attribute `world` of the archives that these plots are for.
  virtual std::string world() const = 0;
  /// Returns all kinds, including k_trace if the world's trace differs from the common one.
  virtual std::vector<Kind> kinds() const = 0;
  /// Throws base::Error: bad_archive for a damaged archive, usage for an unavailable plot,
  /// environment if there is nothing to draw. REQUIRES: a kind of kinds(); an archive of world().
  virtual Picture draw(std::string_view what, const archive::Source& source,
                       const DrawnPart& part) const = 0;
};

/// One entry per world with its own plots.
using PlotsOfWorlds = std::vector<std::unique_ptr<WorldPlots>>;

}  // namespace sleight::pictures
