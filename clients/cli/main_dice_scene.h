// What pictures of dice need of that world. Part of the program's main, where the sides are joined.
#pragma once

#include <string>
#include <string_view>

#include "clients/cli/dice_figures.h"
#include "clients/cli/dice_plausibility.h"

namespace sleight::programs {

/// A cli::DiceSceneReader.
base::Result<cli::DiceScene, std::string> read_dice_scene(std::string_view request_text);

/// A cli::DicePriorReader.
base::Result<cli::DicePrior, std::string> read_dice_prior(std::string_view request_text);

}  // namespace sleight::programs
