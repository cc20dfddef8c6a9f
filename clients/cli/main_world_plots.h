// The worlds of a program that have their own plots, as one function that tests replace.
#pragma once

#include "clients/pictures/world_plots.h"

namespace sleight::programs {

pictures::PlotsOfWorlds plots_of_program();

}  // namespace sleight::programs
