// Commands about the program itself: `sleight config`, `sleight completion` and `sleight man`. The
// build uses `man`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "clients/cli/main_app.h"

namespace sleight::programs {

struct OwnArguments {
  bool json = false;
  std::string shell;
  std::string program = "sleight";
  std::string folder;  ///< for manual pages; empty: prints the program's own page to stdout
};

void add_own_commands(CLI::App& app, OwnArguments& arguments, Action& action);

}  // namespace sleight::programs
