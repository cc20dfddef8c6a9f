// Quotes names and text of a tree for shell scripts. Internal to clients/command_tree. Pure
// functions; thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/command_tree/command_tree.h"

namespace sleight::command_tree {

/// Quotes for bash and zsh, such as 'it'\''s'.
std::string in_single_quotes(std::string_view text);

/// Converts "sleight-batch" to "sleight_batch" for use in a function's name.
std::string identifier(std::string_view name);

/// Returns the names of a command's options, optionally only of those that take a value.
std::vector<std::string> option_names(const Command& command, bool with_value_alone);

/// Replaces `old` everywhere in `text`.
std::string replaced(std::string text, std::string_view old, std::string_view by);

}  // namespace sleight::command_tree
