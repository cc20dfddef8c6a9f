// Commands about the program itself: `sleight config`, `completion`, and `man`, which the build
// calls.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "clients/cli/main_app.h"

namespace sleight::programs {

struct OwnArguments {
  bool json = false;
  std::string shell;
  std::string program = "sleight";
  std::string folder;  ///< of manual pages; empty: the program's own on stdout
};

void add_own_commands(CLI::App& app, OwnArguments& arguments, Action& action);

}  // namespace sleight::programs
