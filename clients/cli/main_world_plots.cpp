#include "clients/cli/main_world_plots.h"

#include <memory>

#include "clients/world_plots/ball_2d.h"
#include "clients/world_plots/dice.h"
#include "clients/world_plots/spelling.h"

namespace sleight::programs {

pictures::PlotsOfWorlds plots_of_program() {
  pictures::PlotsOfWorlds plots;
  plots.push_back(std::make_unique<world_plots::Ball2d>());
  plots.push_back(std::make_unique<world_plots::Dice>());
  plots.push_back(std::make_unique<world_plots::Spelling>());
  return plots;
}

}  // namespace sleight::programs
