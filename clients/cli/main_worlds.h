// Which worlds a program has: one function, that tests replace by their own.
#pragma once

#include "worker/run/catalogue.h"

namespace sleight::programs {

run::Catalogue worlds_of_program();

}  // namespace sleight::programs
