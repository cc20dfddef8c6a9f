// The test programs have no plots for particular worlds.
#include "clients/cli/main_world_plots.h"

namespace sleight::programs {

pictures::PlotsOfWorlds plots_of_program() {
  return {};
}

}  // namespace sleight::programs
