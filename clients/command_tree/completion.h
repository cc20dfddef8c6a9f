// Generates a program's completion scripts for three shells.
//
// Each script is self-contained: bash doesn't need bash-completion. Scripts call the program only
// for job ids. `PROGRAM list --complete` prints a line per job: the id, a tab, a short description.
// If the call fails, the script silently offers nothing. Pure functions of the tree; thread-safe.
#pragma once

#include <string>

#include "clients/command_tree/command_tree.h"

namespace sleight::command_tree {

/// Script for `source <(sleight completion bash)`, or a file in share/bash-completion/completions.
std::string bash_completion(const Command& program);

/// Script for `source <(sleight completion zsh)` after compinit, or a file _sleight in $fpath.
std::string zsh_completion(const Command& program);

/// Script for `sleight completion fish | source`, or a file in fish/vendor_completions.d.
std::string fish_completion(const Command& program);

}  // namespace sleight::command_tree
