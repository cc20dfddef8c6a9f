// `sleight direct`, `check`, `keys` and `replay`: the subcommands that need the worlds.
#pragma once

#include <string>
#include <vector>

#include "clients/cli/main_run.h"

namespace sleight::programs {

/// Runs a request here, in this process.
int direct(const DirectArguments& arguments);

/// Prints the normalised request, with the keys that are set in it, or its errors.
int check_request(const std::string& path, const std::vector<std::string>& sets);

/// Prints all keys of a world, or the worlds when none is named.
int print_keys(const std::string& world);

/// Simulates the state of a failed simulation's file and says how it ends; the exit code.
int replay(const std::string& path, bool json);

}  // namespace sleight::programs
