// The command line of `sleight` as a CLI::App, from which parsing, help, completion and man pages
// come.
//
// Each part of it is added by one function, which says in a CLI::App what the user may give, in its
// arguments where that goes, and in an action what is to be done. An action is set by the parsing
// of its command and called by main alone.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>

namespace sleight::programs {

/// What a parsed command line asks for; it returns the exit code.
using Action = std::function<int()>;

/// Where parsing puts what it reads.
class CommandLine {
 public:
  CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  ~CommandLine();

  Action action;         ///< of the command that was given
  bool verbose = false;  ///< more on stderr

 private:
  friend void build_app(CLI::App& app, CommandLine& line);
  struct Arguments;
  std::unique_ptr<Arguments> arguments_;
};

/// Adds all commands. REQUIRES: `line` outlives the app; each is built once.
void build_app(CLI::App& app, CommandLine& line);

}  // namespace sleight::programs
