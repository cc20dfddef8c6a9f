// The worlds that have plots of their own. Test programs link another definition of this function.
#pragma once

#include "clients/pictures/world_plots.h"

namespace sleight::programs {

pictures::PlotsOfWorlds plots_of_program();

}  // namespace sleight::programs
