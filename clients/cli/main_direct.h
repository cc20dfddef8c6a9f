// `sleight direct`, `check`, `keys` and `replay`: the commands that require the worlds.
#pragma once

#include <string>
#include <vector>

#include "clients/cli/main_run.h"

namespace sleight::programs {

int direct(const DirectArguments& arguments);

/// Prints the normalised request with these keys set, or its errors.
int check_request(const std::string& path, const std::vector<std::string>& sets);

/// Prints all keys of a world, or the names of the worlds if `world` is empty.
int print_keys(const std::string& world);

/// Repeats the failed simulation of a failure file, prints how it ends, and returns the exit code.
int replay(const std::string& path, bool json);

}  // namespace sleight::programs
