// One function a command, each of which hands its arguments to zsh's own _arguments.
#include <fmt/format.h>

#include "clients/command_tree/completion.h"
#include "clients/command_tree/shell_words.h"

namespace sleight::command_tree {
namespace {

/// As a message or an explanation of _arguments.
std::string message(std::string text) {
  text = replaced(std::move(text), "\\", "\\\\");
  text = replaced(std::move(text), "[", "\\[");
  text = replaced(std::move(text), "]", "\\]");
  return replaced(std::move(text), ":", "\\:");
}

/// What _arguments does for a value.
std::string action_of(const Argument& argument) {
  switch (argument.completes()) {
    case Completes::nothing:
      return " ";
    case Completes::choices:
      return fmt::format("({})", joined(argument.choices, ' '));
    case Completes::files: {
      if (argument.suffixes().empty()) return "_files";
      // One suffix alone in parentheses would be a qualifier.
      if (argument.suffixes().size() == 1)
        return fmt::format("_files -g \"*{}\"", argument.suffixes().front());
      return fmt::format("_files -g \"*({})\"", joined(argument.suffixes(), '|'));
    }
    case Completes::folders:
      return "_files -/";
    case Completes::jobs:
      return "_PROGRAM_jobs";
  }
  return " ";
}

/// Lines of _arguments for an option, one a name: "(-o --output)--output=[help]:OUTPUT.h5:action".
std::string option_specs(const Argument& option) {
  std::string specs;
  for (const std::string& name : option.names) {
    std::string spec = option.repeats ? "*" : fmt::format("({})", joined(option.names, ' '));
    spec += name;
    if (!option.is_flag()) spec += name.starts_with("--") ? "=" : "+";
    spec += fmt::format("[{}]", message(option.help));
    if (!option.is_flag())
      spec += fmt::format(":{}:{}", message(option.type_name), action_of(option));
    specs += fmt::format(" \\\n    {}", in_single_quotes(spec));
  }
  return specs;
}

std::string positional_spec(const Argument& positional, std::size_t number) {
  const std::string place = positional.repeats    ? "*:"
                            : positional.required ? fmt::format("{}:", number)
                                                  : fmt::format("{}::", number);
  return fmt::format(" \\\n    {}",
                     in_single_quotes(fmt::format("{}{}:{}", place, message(positional.type_name),
                                                  action_of(positional))));
}

std::string function_of(const Place& place) {
  const Command& command = *place.command;
  const std::string name = identifier(joined(place.words, '_'));
  std::string specs;
  for (const Argument& option : command.options)
    specs += option_specs(option);
  for (std::size_t i = 0; i < command.positionals.size(); ++i)
    specs += positional_spec(command.positionals[i], i + 1);
  if (command.commands.empty())
    return fmt::format("_{}() {{\n  _arguments -s -S :{}\n}}\n\n", name, specs);

  std::string commands;
  std::string calls;
  for (const Command& below : command.commands) {
    commands += fmt::format(
        "        {}\n", in_single_quotes(below.name + ":" + replaced(below.summary, "\\", "\\\\")));
    calls +=
        fmt::format("        {}) _{}_{} && ret=0 ;;\n", below.name, name, identifier(below.name));
  }
  return fmt::format(
      "_{0}() {{\n"
      "  local curcontext=$curcontext state line ret=1\n"
      "  typeset -A opt_args\n"
      "{4}"
      "  _arguments -s -C :{1} \\\n"
      "    '1: :->command' \\\n    '*:: :->arguments' && ret=0\n"
      "  case $state in\n"
      "    command)\n      local -a commands=(\n{2}      )\n"
      "      _describe -t commands command commands && ret=0 ;;\n"
      "    arguments)\n      curcontext=${{curcontext%:*:*}}:{0}-$words[1]:\n"
      "      case $words[1] in\n{3}      esac ;;\n"
      "  esac\n  return ret\n}}\n\n",
      name, specs, commands, calls,
      place.words.size() == 1 ? fmt::format("  local program_of_line=$words[1]\n") : "");
}

/// PROGRAM stands for the program's name in functions. The id's ':' would end it for _describe.
constexpr const char* k_jobs = R"zsh(_PROGRAM_jobs() {
  local -a jobs
  jobs=(${(f)"$(${(Q)program_of_line} list --complete 2>/dev/null </dev/null)"})
  jobs=(${jobs/$'\t'/:})
  (( $#jobs )) && _describe -t jobs job jobs
}

)zsh";

}  // namespace

std::string zsh_completion(const Command& program) {
  std::string script = fmt::format(
      "#compdef {0}\n# Completion of {0} for zsh, made by {0} itself.\n\n", program.name);
  script += k_jobs;
  for (const Place& place : places_of(program))
    script += function_of(place);
  script += fmt::format(
      "# From $fpath this file is the function _{0} itself; read by `source` it tells compinit.\n"
      "if [[ $funcstack[1] == _{0} ]]; then\n  _PROGRAM \"$@\"\nelse\n"
      "  compdef _PROGRAM {0}\nfi\n",
      program.name);
  return replaced(script, "PROGRAM", identifier(program.name));
}

}  // namespace sleight::command_tree
