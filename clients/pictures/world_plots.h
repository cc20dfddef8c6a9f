// Plots that only one world has: how it draws what no other world's archives hold.
//
// `sleight plot` draws any world's trace and animations from what all archives have
// (plot_command.h, animation_figures.h). A world that has more to show, or a trace of its own, says
// so by one WorldPlots in clients/world_plots; a program's main lists these, as it lists the
// worlds. What
// `--what` takes, its help and what is said of a picture that an archive can't have come from the
// list, so no command knows a world's name.
//
// Thread safety: const functions may be called from several threads, on sources of their own.
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

/// What every world's archives can be asked for.
inline constexpr std::string_view k_trace = "trace";
inline constexpr std::string_view k_drawn_animations = "animations";

/// What of an archive is drawn.
struct DrawnPart {
  std::optional<std::uint64_t> chain{};  ///< none: all that the picture has room for
  std::uint64_t draws = 0;               ///< the first so many; 0: all
  std::uint64_t count = 3;               ///< animations, where a picture shows single ones
};

/// A picture, and words to go with it: lines, each ended.
struct Picture {
  plot::Figure figure{};
  std::string words{};
};

class WorldPlots {
 public:
  /// A word of `--what`.
  struct Kind {
    std::string what{};
    std::string help{};  ///< what it shows, in a few words; unused of k_trace
  };

  virtual ~WorldPlots() = default;
  /// Whose archives these are of: their attribute `world`.
  virtual std::string world() const = 0;
  /// All that it draws; k_trace among them where its trace is another than everyone's.
  virtual std::vector<Kind> kinds() const = 0;
  /// Throws base::Error: bad_archive on a damaged archive, usage on what this one can't have,
  /// environment where there is nothing to draw. REQUIRES: one of its kinds; an archive of its
  /// world.
  virtual Picture draw(std::string_view what, const archive::Source& source,
                       const DrawnPart& part) const = 0;
};

/// Of the worlds that have some: one entry a world.
using PlotsOfWorlds = std::vector<std::unique_ptr<WorldPlots>>;

}  // namespace sleight::pictures
