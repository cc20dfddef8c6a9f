// Completion scripts of a program for three shells.
//
// Each script stands for itself: bash needs no bash-completion, and no script asks the program for
// anything but job ids. `PROGRAM list --complete` prints these, a line a job: the id, a tab, a few
// words; where it fails nothing is offered and nothing is said.
//
// Pure functions of the tree; thread-safe.
#pragma once

#include <string>

#include "clients/command_tree/command_tree.h"

namespace sleight::command_tree {

/// For `source <(sleight completion bash)` or a file in share/bash-completion/completions.
std::string bash_completion(const Command& program);

/// For `source <(sleight completion zsh)` after compinit, or a file _sleight in $fpath.
std::string zsh_completion(const Command& program);

/// For `sleight completion fish | source` or a file in fish/vendor_completions.d.
std::string fish_completion(const Command& program);

}  // namespace sleight::command_tree
