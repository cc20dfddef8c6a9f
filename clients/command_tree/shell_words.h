// How names and words of a tree are quoted in shell scripts. Internal to clients/command_tree.
//
// Pure functions; thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/command_tree/command_tree.h"

namespace sleight::command_tree {

/// 'it'\''s': for bash and zsh.
std::string in_single_quotes(std::string_view text);

/// "sleight-batch" as part of a function's name: "sleight_batch".
std::string identifier(std::string_view name);

/// Names of a command's options; those alone that take a value, on request.
std::vector<std::string> option_names(const Command& command, bool with_value_alone);

/// `text` with `old` replaced everywhere.
std::string replaced(std::string text, std::string_view old, std::string_view by);

}  // namespace sleight::command_tree
