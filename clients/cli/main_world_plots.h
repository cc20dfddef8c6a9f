// Which worlds of a program have plots of their own: one function, that tests replace by their own.
#pragma once

#include "clients/cli/world_plots.h"

namespace sleight::programs {

cli::PlotsOfWorlds plots_of_program();

}  // namespace sleight::programs
