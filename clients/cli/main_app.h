// The command line of `sleight` as a CLI::App, which also generates help, completion and man pages.
//
// For each command, one function adds the command and its options. Parsing stores values in the
// command's arguments. Parsing stores the command's action. Only main calls it.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>

namespace sleight::programs {

/// The action that a parsed command line asks for. Returns the exit code.
using Action = std::function<int()>;

/// Stores the parsed command line.
class CommandLine {
 public:
  CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  ~CommandLine();

  Action action;         ///< of the given command
  bool verbose = false;  ///< print more to stderr

 private:
  friend void build_app(CLI::App& app, CommandLine& line);
  struct Arguments;
  std::unique_ptr<Arguments> arguments_;
};

/// Adds all commands. REQUIRES: `line` must outlive `app`. Use both only once.
void build_app(CLI::App& app, CommandLine& line);

}  // namespace sleight::programs
