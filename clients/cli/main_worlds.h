// The worlds of a program. Test programs link another definition of this function.
#pragma once

#include "worker/run/catalogue.h"

namespace sleight::programs {

run::Catalogue worlds_of_program();

}  // namespace sleight::programs
