// What pictures of balls that spell need of that world. Part of the program's main, where the sides
// are joined.
#pragma once

#include <string>
#include <string_view>

#include "clients/cli/spelling_figures.h"

namespace sleight::programs {

/// A cli::SpellingBoxReader.
base::Result<cli::SpellingBox, std::string> read_spelling_box(std::string_view request_text);

}  // namespace sleight::programs
