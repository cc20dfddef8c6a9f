// The worlds of a program, as one function that tests replace.
#pragma once

#include "worker/run/catalogue.h"

namespace sleight::programs {

run::Catalogue worlds_of_program();

}  // namespace sleight::programs
