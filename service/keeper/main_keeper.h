// The main of `sleight-keeper`, to which tests give moments at which it dies.
#pragma once

#include "service/keeper/moments.h"

namespace sleight::programs {

/// Returns the exit code.
int keeper_main(int argc, char** argv, keeper::Moments& moments);

}  // namespace sleight::programs
