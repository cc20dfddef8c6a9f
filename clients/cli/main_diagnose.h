// How `sleight diagnose` judges scalars: with the measures of worker/sampling/diagnostics. Part of
// the program's main, where the sides are joined.
#pragma once

#include "clients/cli/diagnosis.h"

namespace sleight::programs {

cli::Rules convergence_rules();

}  // namespace sleight::programs
