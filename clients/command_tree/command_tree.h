// What a program's command line takes, as a plain value: made from its CLI::App, from which the
// help is made too, so that completion and man pages can't say anything else.
//
// A command's footer is cut into what it holds: paragraphs are parted by empty lines; one that
// opens with "Example:" or "Examples:" has an example a line, one that opens with "Exit codes:"
// tells these, all others are paragraphs of the description.
//
// Invariants
//   1. What is hidden from the help (a group of no name) is not in the tree.
//   2. Options and commands stand in the order of the help.
//   3. A positional that repeats is the last one.
// Values; thread-safe as such.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sleight::command_tree {

/// What a value is completed to.
enum class Completes {
  nothing,
  choices,
  files,  ///< with one of `suffixes`, or any file without these; and folders on the way
  folders,
  jobs,  ///< ids that `sleight list --complete` tells
};

/// An option or a positional.
struct Argument {
  std::vector<std::string> names;    ///< "-o", "--output"; of a positional none
  std::string name;                  ///< of a positional: "request"
  std::string type_name;             ///< "OUTPUT.h5"; empty: a flag
  std::vector<std::string> choices;  ///< that the value is one of
  std::string help;
  std::string fallback;  ///< the default, where the help tells one
  bool required = false;
  bool repeats = false;

  bool is_flag() const { return type_name.empty(); }
  /// By choices and type name: REQUEST.toml and FILE.svg|FILE.png are files with these suffixes;
  /// FOLDER, DIR and NAME.h5.run folders; FILE and PIPE any files; JOB jobs.
  Completes completes() const;
  /// ".svg", ".png" of FILE.svg|FILE.png.
  std::vector<std::string> suffixes() const;
};

struct Command {
  std::string name;     ///< "direct"
  std::string summary;  ///< one paragraph
  std::vector<Argument> options;
  std::vector<Argument> positionals;
  std::vector<Command> commands;
  std::vector<std::string> paragraphs;
  std::vector<std::string> examples;
  std::string exit_codes;  ///< "0 done; 1 a bug"
};

/// The tree of a program. REQUIRES: the app has a name.
Command tree_of(const CLI::App& app);

/// A command with the words that lead to it: {"sleight", "archive", "info"}.
struct Place {
  std::vector<std::string> words;
  const Command* command = nullptr;
};

/// All commands of a tree, the program first, each before those below it. They borrow from `tree`.
std::vector<Place> places_of(const Command& tree);

/// "sleight archive info", "sleight-archive-info".
std::string joined(const std::vector<std::string>& words, char between);

}  // namespace sleight::command_tree
