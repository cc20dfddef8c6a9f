// What pictures need of a world: dice on their table, the box of balls that spell. Part of the
// program's main, where the sides are joined.
#pragma once

#include <string>
#include <string_view>

#include "clients/cli/dice_figures.h"
#include "clients/cli/dice_plausibility.h"
#include "clients/cli/spelling_figures.h"

namespace sleight::programs {

/// A cli::DiceSceneReader.
base::Result<cli::DiceScene, std::string> read_dice_scene(std::string_view request_text);

/// A cli::DicePriorReader.
base::Result<cli::DicePrior, std::string> read_dice_prior(std::string_view request_text);

/// A cli::SpellingBoxReader.
base::Result<cli::SpellingBox, std::string> read_spelling_box(std::string_view request_text);

}  // namespace sleight::programs
