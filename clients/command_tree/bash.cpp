// The script has two tables (a command's options and subcommands, and how to complete a value) and
// a function that follows the words of the command line through them.
#include <fmt/format.h>

#include "clients/command_tree/completion.h"
#include "clients/command_tree/shell_words.h"

namespace sleight::command_tree {
namespace {

/// NAME and FUNCTION are placeholders for the program's name and the function's.
constexpr const char* k_bash_walk = R"bash(
# Completes folders, and files with one of the given suffixes (no suffix: all files).
_FUNCTION_files() {
  local file suffix value=$1
  shift
  # Removes the quotes of the command line.
  value=${value#[\"\']}
  value=${value//\\/}
  compopt -o filenames 2>/dev/null
  while IFS= read -r file; do
    if [[ -d ${file/#\~\//$HOME/} || $# -eq 0 ]]; then
      COMPREPLY+=("$file")
    else
      for suffix in "$@"; do
        [[ $file == *"$suffix" ]] && COMPREPLY+=("$file")
      done
    fi
  done < <(compgen -f -- "$value")
}

_FUNCTION_folders() {
  local folder value=${1#[\"\']}
  compopt -o filenames 2>/dev/null
  while IFS= read -r folder; do
    COMPREPLY+=("$folder")
  done < <(compgen -d -- "${value//\\/}")
}

_FUNCTION_jobs() {
  local job
  while IFS=$'\t' read -r job _; do
    [[ $job == "$1"* ]] && COMPREPLY+=("$job")
  done < <("${line[0]/#\~\//$HOME/}" list --complete 2>/dev/null </dev/null)
}

_FUNCTION() {
  local IFS=$' \t\n' commands options valued kind
  local path=NAME option='' place=0 is_over='' joins='' word i
  local -a line=() args=()
  COMPREPLY=()

  # Joins the words that bash splits at = and :.
  for ((i = 0; i <= COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ $i -gt 1 && ( $joins || ( $word && $word != *[!=:]* ) ) ]]; then
      line[${#line[@]}-1]+=$word
    else
      line+=("$word")
    fi
    joins=''
    [[ $word && $word != *[!=:]* ]] && joins=1
  done
  local current=${line[${#line[@]}-1]}
  unset "line[${#line[@]}-1]"

  # Finds the command that the words name.
  _FUNCTION_has "$path"
  for word in "${line[@]:1}"; do
    if [[ $option ]]; then
      option=''
    elif [[ ! $is_over && $word == -- ]]; then
      is_over=1
    elif [[ ! $is_over && $word == -?* ]]; then
      [[ $valued == *" $word "* ]] && option=$word
    elif [[ $place -eq 0 && $commands == *" $word "* ]]; then
      path+=" $word"
      _FUNCTION_has "$path"
    else
      place=$((place + 1))
    fi
  done

  # Completes the current word.
  local value=$current before=''
  if [[ $option ]]; then
    _FUNCTION_value "$path:$option"
  elif [[ ! $is_over && $current == --*=* ]]; then
    value=${current#*=}
    before=${current%%=*}=
    _FUNCTION_value "$path:${before%=}"
  elif [[ ! $is_over && $current == -* ]]; then
    kind=choices args=($options)
  elif [[ $place -eq 0 && $commands != ' ' ]]; then
    kind=choices args=($commands)
  else
    _FUNCTION_value "$path:$((place + 1))"
  fi
  case $kind in
    choices) COMPREPLY=($(compgen -W "${args[*]}" -- "$value")) ;;
    files) _FUNCTION_files "$value" "${args[@]}" ;;
    folders) _FUNCTION_folders "$value" ;;
    jobs) _FUNCTION_jobs "$value" ;;
  esac

  # bash replaces only the last part of a word that it has split.
  local kept=''
  [[ $current == [\"\']* ]] || kept=${current%"${current##*[=:]}"}
  for i in "${!COMPREPLY[@]}"; do
    word=$before${COMPREPLY[i]}
    [[ $COMP_WORDBREAKS == *=* && $COMP_WORDBREAKS == *:* ]] && word=${word#"$kept"}
    COMPREPLY[i]=$word
  done
}

complete -F _FUNCTION NAME
)bash";

/// Returns the shell assignments for an argument's completion; empty if there is no completion.
std::string value_of(const Argument& argument) {
  switch (argument.completes()) {
    case Completes::nothing:
      return "";
    case Completes::choices: {
      std::vector<std::string> args;
      for (const std::string& choice : argument.choices)
        args.push_back(in_single_quotes(choice));
      return fmt::format("kind=choices args=({})", joined(args, ' '));
    }
    case Completes::files:
      return fmt::format("kind=files args=({})", joined(argument.suffixes(), ' '));
    case Completes::folders:
      return "kind=folders";
    case Completes::jobs:
      return "kind=jobs";
  }
  return "";
}

std::string spaced(const std::vector<std::string>& words) {
  return words.empty() ? " " : fmt::format(" {} ", joined(words, ' '));
}

}  // namespace

std::string bash_completion(const Command& program) {
  std::string has;
  std::string values;
  for (const Place& place : places_of(program)) {
    const std::string path = joined(place.words, ' ');
    std::vector<std::string> commands;
    for (const Command& below : place.command->commands)
      commands.push_back(below.name);
    has += fmt::format("    {})\n      commands={}\n      options={}\n      valued={} ;;\n",
                       in_single_quotes(path), in_single_quotes(spaced(commands)),
                       in_single_quotes(spaced(option_names(*place.command, false))),
                       in_single_quotes(spaced(option_names(*place.command, true))));
    for (const Argument& option : place.command->options) {
      const std::string value = value_of(option);
      if (value.empty()) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names)
        patterns.push_back(in_single_quotes(fmt::format("{}:{}", path, name)));
      values += fmt::format("    {}) {} ;;\n", joined(patterns, '|'), value);
    }
    for (std::size_t i = 0; i < place.command->positionals.size(); ++i) {
      const Argument& positional = place.command->positionals[i];
      const std::string value = value_of(positional);
      if (value.empty()) continue;
      values += positional.repeats
                    ? fmt::format("    {}[0-9]*) {} ;;\n", in_single_quotes(path + ":"), value)
                    : fmt::format("    {}) {} ;;\n",
                                  in_single_quotes(fmt::format("{}:{}", path, i + 1)), value);
    }
  }
  const std::string function = identifier(program.name);
  const std::string walk =
      replaced(replaced(k_bash_walk, "FUNCTION", function), "NAME", program.name);
  return fmt::format(
      "# bash completion for {0}, generated by `sleight completion`.\n\n"
      "# The commands and options of a command.\n"
      "_{1}_has() {{\n"
      "  case $1 in\n"
      "{2}  esac\n"
      "}}\n\n"
      "# How to complete the value of an option, or a positional by its number.\n"
      "_{1}_value() {{\n  kind='' args=()\n  case $1 in\n{3}    *) ;;\n  esac\n}}\n{4}",
      program.name, function, has, values, walk);
}

}  // namespace sleight::command_tree
