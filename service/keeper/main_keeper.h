// The main function of `sleight-keeper`. A test can choose the Moment at which the keeper dies.
#pragma once

#include "service/keeper/moments.h"

namespace sleight::programs {

int keeper_main(int argc, char** argv, keeper::Moments& moments);

}  // namespace sleight::programs
