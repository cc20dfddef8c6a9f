// Pictures of dice that come to rest as is wanted: the thesis's figure 2.13.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/cli/dice_motions.h"
#include "clients/plot/figure.h"
#include "common/archive/model.h"
#include "common/base/result.h"

namespace sleight::cli {

/// What a request for dice says of the picture. Lengths in millimetres, dice counted from 0.
struct DiceScene {
  struct Place {
    std::uint64_t die = 0;
    plot::Point centre_mm{};
    double tolerance_mm = 0;
  };
  struct Region {
    std::uint64_t die = 0;
    plot::Point low_mm{};
    plot::Point high_mm{};
  };
  std::uint64_t dice = 0;
  double side_mm = 0;
  double spacing_mm = 0;  ///< of the table's control points
  std::vector<Place> places{};
  std::vector<Region> regions{};
};

/// The scene of a request's text, or what is wrong with a text that is no request for the world
/// "dice". Its keys have the world's own defaults, so a program's main, where the sides are joined,
/// gives this function.
using DiceSceneReader =
    std::function<base::Result<DiceScene, std::string>(std::string_view request_text)>;

/// What one panel shows.
struct DiceAnimation {
  std::string title;
  std::vector<DieMotion> dice;  ///< each with a piece at least
};

/// A panel for each animation, beside each other, all with one scale: the table from above and,
/// beneath, from the front. Of each die its centre at equal times, the cube at each third of them,
/// fading in, and where it lies at last, with the pips of its numbering; wanted places are rings of
/// the tolerance. Lines on the table join its control points, whose heights archives don't hold.
/// REQUIRES: an animation at least.
plot::Figure dice_figure(const std::string& title, const DiceScene& scene,
                         const std::vector<DiceAnimation>& animations);

struct DiceAnimationOptions {
  std::optional<std::uint64_t> chain{};  ///< none: of all chains
  std::size_t count = 4;                 ///< at most so many animations
  bool front = true;                     ///< without: the views from above alone, in millimetres
};

/// The same of an archive's kept animations, chosen as choose_animations does.
plot::Figure dice_animations(const archive::Source& source, const DiceScene& scene,
                             const DiceAnimationOptions& options);

}  // namespace sleight::cli
