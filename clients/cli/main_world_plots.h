// Which worlds of a program have plots of their own: one function, that tests replace by their own.
#pragma once

#include "clients/pictures/world_plots.h"

namespace sleight::programs {

pictures::PlotsOfWorlds plots_of_program();

}  // namespace sleight::programs
