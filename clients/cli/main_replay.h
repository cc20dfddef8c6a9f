// `sleight replay`: part of the program's main, where the sides are joined.
#pragma once

#include <string>

namespace sleight::programs {

/// Simulates the state of a failed simulation's file and says how it ends; the exit code.
int replay(const std::string& path, bool json);

}  // namespace sleight::programs
