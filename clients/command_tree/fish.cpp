// The script has a `complete` line for each command, option and positional. Each line calls `_at`
// to test whether the words so far lead to its command.
#include <fmt/format.h>

#include "clients/command_tree/completion.h"
#include "clients/command_tree/shell_words.h"

namespace sleight::command_tree {
namespace {

/// Placeholders are NAME and FUNCTION (the program's name and function), VALUED (the options that
/// take a value) and COMMANDS (all commands).
constexpr const char* k_fish_walk = R"fish(
# Prints the command that the words before the cursor name, and the number of the next positional.
function __fish_FUNCTION_place
    set -l path NAME
    set -l place 1
    set -l is_value 0
    set -l is_over 0
    set -l words (commandline -opc)
    for word in $words[2..-1]
        if test $is_value = 1
            set is_value 0
        else if test $is_over = 0; and test "$word" = --
            set is_over 1
        else if test $is_over = 0; and string match -q -- '-?*' $word
            switch "$path:$word"
                case VALUED
                    set is_value 1
            end
        else
            switch "$place:$path $word"
                case COMMANDS
                    set path "$path $word"
                case '*'
                    set place (math $place + 1)
            end
        end
    end
    echo $path
    echo $place
end

# Whether the words name this command and, if a number is given, the cursor is at this positional
# ("1+": at this one or a later one).
function __fish_FUNCTION_at
    set -l found (__fish_FUNCTION_place)
    test "$found[1]" = "$argv[1]"; or return 1
    switch "$argv[2]"
        case ''
            return 0
        case '*+'
            test $found[2] -ge (string trim -c + -- $argv[2])
        case '*'
            test $found[2] = $argv[2]
    end
end

# Completes folders, and files with one of these suffixes.
function __fish_FUNCTION_files
    set -l word (string replace -r -- '^--?[^=]*=' '' (commandline -ct))
    set -l ends (string join '|' -- / (string escape --style=regex -- $argv))
    complete -C "'' $word" | string match -r -- "^[^\t]*(?:$ends)(?:\t.*)?\$"
end

function __fish_FUNCTION_jobs
    set -l words (commandline -opc)
    $words[1] list --complete 2>/dev/null </dev/null
end

complete -c NAME -f
)fish";

/// Escapes \ and ' with \, as in fish's single quotes.
std::string quoted_for_fish(std::string_view text) {
  return fmt::format("'{}'", replaced(replaced(std::string(text), "\\", "\\\\"), "'", "\\'"));
}

/// Returns the switches of `complete` for a value: -a with the completions, -F for any files.
std::string value_of(const Argument& argument, std::string_view function) {
  switch (argument.completes()) {
    case Completes::nothing:
      return "";
    case Completes::choices:
      return fmt::format(" -a {}", quoted_for_fish(joined(argument.choices, ' ')));
    case Completes::files:
      if (argument.suffixes().empty()) return " -F";
      return fmt::format(" -a '(__fish_{}_files {})'", function, joined(argument.suffixes(), ' '));
    case Completes::folders:
      return fmt::format(" -a '(__fish_{}_files)'", function);
    case Completes::jobs:
      return fmt::format(" -k -a '(__fish_{}_jobs)'", function);
  }
  return "";
}

std::string option_line(const Argument& option, const std::string& start,
                        std::string_view function) {
  std::string line = start;
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? fmt::format(" -l {}", name.substr(2))
                                   : fmt::format(" -s {}", name.substr(1));
  const std::string value = value_of(option, function);
  // -x: requires a value, no files. -r: requires a value that may be a file.
  if (!option.is_flag()) line += (value == " -F" ? " -r" : " -x") + value;
  return fmt::format("{} -d {}\n", line, quoted_for_fish(option.help));
}

/// Returns patterns for a `case`, which needs at least one.
std::string patterns(const std::vector<std::string>& found) {
  return found.empty() ? "''" : joined(found, ' ');
}

}  // namespace

std::string fish_completion(const Command& program) {
  const std::string function = identifier(program.name);
  std::vector<std::string> valued;
  std::vector<std::string> commands;
  std::string lines;
  for (const Place& place : places_of(program)) {
    const std::string path = joined(place.words, ' ');
    const auto start = [&](const std::string& number) {
      const std::string condition =
          fmt::format("__fish_{}_at \"{}\" {}", function, path, number.empty() ? "''" : number);
      return fmt::format("complete -c {} -n {}", program.name, quoted_for_fish(condition));
    };
    for (const std::string& name : option_names(*place.command, true))
      valued.push_back(quoted_for_fish(fmt::format("{}:{}", path, name)));
    for (const Command& below : place.command->commands) {
      commands.push_back(quoted_for_fish(fmt::format("1:{} {}", path, below.name)));
      lines += fmt::format("{} -a {} -d {}\n", start("1"), quoted_for_fish(below.name),
                           quoted_for_fish(below.summary));
    }
    for (const Argument& option : place.command->options)
      lines += option_line(option, start(""), function);
    for (std::size_t i = 0; i < place.command->positionals.size(); ++i) {
      const Argument& positional = place.command->positionals[i];
      const std::string value = value_of(positional, function);
      if (!value.empty())
        lines += start(fmt::format("{}{}", i + 1, positional.repeats ? "+" : "")) + value + "\n";
    }
  }
  std::string walk = replaced(k_fish_walk, "FUNCTION", function);
  walk = replaced(replaced(walk, "VALUED", patterns(valued)), "COMMANDS", patterns(commands));
  return fmt::format("# fish completion for {0}, generated by `sleight completion`.\n",
                     program.name) +
         replaced(walk, "NAME", program.name) + lines;
}

}  // namespace sleight::command_tree
