#include "clients/command_tree/command_tree.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <utility>

#include "common/base/check.h"

namespace sleight::command_tree {
namespace {

constexpr std::string_view k_exit_codes = "Exit codes: ";

std::vector<std::string> split(const std::string& text, char between) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, between);)
    parts.push_back(part);
  return parts;
}

/// CLI11 writes a type and its checks as "TABLE:{posterior,stats}".
std::vector<std::string> choices_in(const std::string& type_name) {
  const std::size_t open = type_name.find(":{");
  const std::size_t close = type_name.find('}', open);
  if (open == std::string::npos || close == std::string::npos) return {};
  return split(type_name.substr(open + 2, close - open - 2), ',');
}

Argument argument_of(const CLI::Option& option) {
  Argument argument;
  for (const std::string& name : option.get_snames())
    argument.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames())
    argument.names.push_back("--" + name);
  if (!option.nonpositional()) argument.name = option.get_name(true);
  argument.help = option.get_description();
  argument.required = option.get_required();
  argument.repeats = option.get_items_expected_max() > 1;
  if (option.get_items_expected_max() == 0) return argument;
  const std::string type_name = option.get_type_name();
  argument.type_name = type_name.substr(0, type_name.find(':'));
  if (argument.type_name.empty()) argument.type_name = "VALUE";
  argument.choices = choices_in(type_name);
  argument.fallback = option.get_default_str();
  return argument;
}

/// Joins the lines of a paragraph.
std::string filled(const std::string& paragraph) {
  std::string text;
  std::istringstream in(paragraph);
  for (std::string word; in >> word;)
    text += (text.empty() ? "" : " ") + word;
  return text;
}

void take_paragraph(const std::string& paragraph, Command& command) {
  std::vector<std::string> lines = split(paragraph, '\n');
  if (lines.front() == "Example:" || lines.front() == "Examples:") {
    for (std::size_t i = 1; i < lines.size(); ++i)
      command.examples.push_back(lines[i].substr(std::min(lines[i].find_first_not_of(' '),  //
                                                          lines[i].size())));
  } else if (paragraph.starts_with(k_exit_codes)) {
    command.exit_codes = filled(paragraph.substr(k_exit_codes.size()));
  } else {
    command.paragraphs.push_back(filled(paragraph));
  }
}

void take_footer(const std::string& footer, Command& command) {
  std::string paragraph;
  for (const std::string& line : split(footer, '\n')) {
    if (!line.empty()) {
      paragraph += line + '\n';
    } else if (!paragraph.empty()) {
      take_paragraph(std::exchange(paragraph, {}), command);
    }
  }
  if (!paragraph.empty()) take_paragraph(paragraph, command);
}

void take_options(const CLI::App& app, Command& command) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    std::vector<Argument>& kind = option->nonpositional() ? command.options : command.positionals;
    kind.push_back(argument_of(*option));
  }
}

}  // namespace

Completes Argument::completes() const {
  if (!choices.empty()) return Completes::choices;
  if (type_name == "JOB") return Completes::jobs;
  static constexpr std::array<std::string_view, 3> k_folders{"FOLDER", "DIR", "DIRECTORY"};
  static constexpr std::array<std::string_view, 2> k_files{"FILE", "PIPE"};
  if (std::find(k_folders.begin(), k_folders.end(), type_name) != k_folders.end() ||
      type_name.ends_with(".run"))
    return Completes::folders;
  if (std::find(k_files.begin(), k_files.end(), type_name) != k_files.end() || !suffixes().empty())
    return Completes::files;
  return Completes::nothing;
}

std::vector<std::string> Argument::suffixes() const {
  std::vector<std::string> found;
  for (const std::string& kind : split(type_name, '|')) {
    const std::size_t dot = kind.rfind('.');
    if (dot != std::string::npos && dot > 0 && dot + 1 < kind.size())
      found.push_back(kind.substr(dot));
  }
  return found;
}

Command tree_of(const CLI::App& app) {
  CHECK(!app.get_name().empty());
  Command command;
  command.name = app.get_name();
  command.summary = filled(app.get_description());
  take_options(app, command);
  // CLI11 copies a footer to subcommands without one.
  const CLI::App* above = app.get_parent();
  if (above == nullptr || above->get_footer() != app.get_footer())
    take_footer(app.get_footer(), command);
  for (const CLI::App* below : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (below->get_group().empty()) continue;
    if (below->get_name().empty()) {
      take_options(*below, command);  // a group of options
    } else {
      command.commands.push_back(tree_of(*below));
    }
  }
  return command;
}

std::vector<Place> places_of(const Command& tree) {
  std::vector<Place> places{{{tree.name}, &tree}};
  for (const Command& below : tree.commands) {
    for (Place& place : places_of(below)) {
      place.words.insert(place.words.begin(), tree.name);
      places.push_back(std::move(place));
    }
  }
  return places;
}

std::string joined(const std::vector<std::string>& words, char between) {
  std::string text;
  for (const std::string& word : words)
    text += (text.empty() ? "" : std::string(1, between)) + word;
  return text;
}

}  // namespace sleight::command_tree
