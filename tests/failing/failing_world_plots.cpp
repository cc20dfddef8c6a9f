// Plots of the programs for tests of failures: those of every world.
#include "clients/cli/main_world_plots.h"

namespace sleight::programs {

pictures::PlotsOfWorlds plots_of_program() {
  return {};
}

}  // namespace sleight::programs
