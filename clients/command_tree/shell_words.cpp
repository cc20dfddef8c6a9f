#include "clients/command_tree/shell_words.h"

#include <fmt/format.h>

namespace sleight::command_tree {

std::string replaced(std::string text, std::string_view old, std::string_view by) {
  for (std::size_t at = text.find(old); at != std::string::npos;
       at = text.find(old, at + by.size()))
    text.replace(at, old.size(), by);
  return text;
}

std::string in_single_quotes(std::string_view text) {
  return fmt::format("'{}'", replaced(std::string(text), "'", "'\\''"));
}

std::string identifier(std::string_view name) {
  return replaced(std::string(name), "-", "_");
}

std::vector<std::string> option_names(const Command& command, bool with_value_alone) {
  std::vector<std::string> names;
  for (const Argument& option : command.options) {
    if (with_value_alone && option.is_flag()) continue;
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

}  // namespace sleight::command_tree
