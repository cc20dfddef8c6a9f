// A program's command line as a plain value, from which completion scripts and man pages are made.
// The tree is built from the CLI::App that also makes the help, so all three agree.
//
// A command's footer consists of paragraphs between empty lines. A paragraph that begins with
// "Example:" or "Examples:" has one example per line; one that begins with "Exit codes:" lists exit
// codes. Other paragraphs belong to the description.
//
// Invariants
//   1. Options and commands that the help hides (in a group without a name) aren't in the tree.
//   2. Options and commands are in the order of the help.
//   3. Only the last positional can repeat.
// Thread-safe as any value.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sleight::command_tree {

/// How a value is completed.
enum class Completes {
  nothing,
  choices,
  files,  ///< files with one of `suffixes` (any file if there are none), and folders
  folders,
  jobs,  ///< ids from `sleight list --complete`
};

struct Argument {
  std::vector<std::string> names;    ///< such as "-o", "--output"; empty for a positional
  std::string name;                  ///< name of a positional, such as "request"
  std::string type_name;             ///< such as "OUTPUT.h5"; empty: a flag
  std::vector<std::string> choices;  ///< allowed values; empty: any
  std::string help;
  std::string fallback;  ///< default value, if the help shows one
  bool required = false;
  bool repeats = false;

  bool is_flag() const { return type_name.empty(); }
  /// The completion depends on `choices` and `type_name`. REQUEST.toml and FILE.svg|FILE.png are
  /// files with these suffixes; FOLDER, DIR and NAME.h5.run are folders; FILE and PIPE are any
  /// files; JOB is a job.
  Completes completes() const;
  /// Returns, for example, ".svg" and ".png" for FILE.svg|FILE.png.
  std::vector<std::string> suffixes() const;
};

struct Command {
  std::string name;     ///< such as "direct"
  std::string summary;  ///< one paragraph
  std::vector<Argument> options;
  std::vector<Argument> positionals;
  std::vector<Command> commands;
  std::vector<std::string> paragraphs;
  std::vector<std::string> examples;
  std::string exit_codes;  ///< such as "0 done; 1 a bug"
};

/// Returns the tree of a program. REQUIRES: the app has a name.
Command tree_of(const CLI::App& app);

/// A command and its full name, such as {"sleight", "archive", "info"}.
struct Place {
  std::vector<std::string> words;
  const Command* command = nullptr;
};

/// Returns all commands of a tree, each before its subcommands. Refers to `tree`.
std::vector<Place> places_of(const Command& tree);

/// Returns, for example, "sleight archive info" or "sleight-archive-info".
std::string joined(const std::vector<std::string>& words, char between);

}  // namespace sleight::command_tree
