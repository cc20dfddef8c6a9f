#include "clients/command_tree/man_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>

#include "clients/command_tree/shell_words.h"

namespace sleight::command_tree {
namespace {

/// mandoc warns about longer lines.
constexpr std::size_t k_line_bytes_max = 78;

/// Escapes text for troff.
std::string escaped(std::string_view text) {
  std::string line = replaced(std::string(text), "\\", "\\e");
  line = replaced(std::move(line), "-", "\\-");
  if (!line.empty() && (line.front() == '.' || line.front() == '\'')) line.insert(0, "\\&");
  return line;
}

/// Returns a quoted argument of a macro, so that mdoc doesn't interpret it as a macro.
std::string argument(std::string_view text) {
  return "\"\\&" + replaced(escaped(text), "\"", "\\(dq") + "\"";
}

/// Wraps a paragraph, and starts each sentence on a new line.
std::string wrapped(std::string_view text) {
  std::string lines;
  std::string line;
  const auto end_line = [&] {
    if (!line.empty()) lines += line + "\n";
    line.clear();
  };
  std::istringstream in{std::string(text)};
  for (std::string word; in >> word;) {
    const std::string next = escaped(word);
    if (!line.empty() && line.size() + 1 + next.size() > k_line_bytes_max) end_line();
    line += (line.empty() ? "" : " ") + next;
    const bool ends_sentence = word.find_last_of(".!?") == word.size() - 1 && word.size() > 1;
    if (ends_sentence) end_line();
  }
  end_line();
  return lines;
}

/// Returns a help text as a sentence with a capital and a full stop.
std::string sentence(std::string text) {
  if (text.empty()) return text;
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  if (std::string_view(".!?").find(text.back()) == std::string_view::npos) text += '.';
  return text;
}

/// Returns the description that follows a page's name in an index: no capital, no full stop, and
/// without the program's name.
std::string description(std::string text, const std::string& program) {
  if (std::tolower(static_cast<unsigned char>(text.empty() ? ' ' : text.front())) ==
          program.front() &&
      text.substr(1).starts_with(program.substr(1) + " "))
    text.erase(0, program.size() + 1);
  const std::size_t end = text.find_first_of(":.");
  if (end != std::string::npos) text.resize(end);
  if (text.size() > 1 && std::isupper(static_cast<unsigned char>(text[1])) == 0)
    text.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(text.front())));
  return text;
}

/// Returns, for example, "Fl o , Fl -output Ar OUTPUT.h5", with `between` between the names.
std::string flags(const Argument& option, std::string_view between) {
  std::string text;
  for (const std::string& name : option.names) {
    if (!text.empty()) text += fmt::format(" {} ", between);
    text += "Fl " + argument(name.substr(1));
  }
  if (!option.is_flag()) text += " Ar " + argument(option.type_name);
  return text;
}

std::string synopsis(const Place& place) {
  const Command& command = *place.command;
  std::string text = ".Sh SYNOPSIS\n.Nm " + argument(place.words.front()) + "\n";
  for (std::size_t i = 1; i < place.words.size(); ++i)
    text += ".Cm " + argument(place.words[i]) + "\n";
  for (const Argument& option : command.options) {
    if (option.names.front() == "-h") continue;
    text += (option.required ? "." : ".Op ") + flags(option, "|") +
            (option.repeats ? " No ..." : "") + "\n";
  }
  for (const Argument& positional : command.positionals) {
    text += (positional.required ? ".Ar " : ".Op Ar ") + argument(positional.type_name) +
            (positional.repeats ? " ..." : "") + "\n";
  }
  if (!command.commands.empty()) text += ".Ar command\n.Op Ar argument ...\n";
  return text;
}

std::string help_of(const Argument& argument_) {
  std::string text = wrapped(sentence(argument_.help));
  if (!argument_.choices.empty())
    text += wrapped("One of " + replaced(joined(argument_.choices, ','), ",", ", ") + ".");
  if (!argument_.fallback.empty()) text += wrapped("Default: " + argument_.fallback + ".");
  return text;
}

std::string arguments(const Command& command) {
  std::string text;
  if (!command.positionals.empty()) {
    text += ".Pp\nThe arguments are as follows:\n.Bl -tag -width Ds\n";
    for (const Argument& positional : command.positionals)
      text += ".It Ar " + argument(positional.type_name) + "\n" + help_of(positional);
    text += ".El\n";
  }
  if (!command.options.empty()) {
    text += ".Pp\nThe options are as follows:\n.Bl -tag -width Ds\n";
    for (const Argument& option : command.options)
      text += ".It " + flags(option, ",") + "\n" + help_of(option);
    text += ".El\n";
  }
  if (!command.commands.empty()) {
    text += ".Pp\nThe commands are as follows:\n.Bl -tag -width Ds\n";
    for (const Command& below : command.commands)
      text += ".It Cm " + argument(below.name) + "\n" + wrapped(sentence(below.summary));
    text += ".El\n";
  }
  return text;
}

std::string examples(const Command& command) {
  if (command.examples.empty()) return "";
  std::string text = ".Sh EXAMPLES\n.Bd -literal -offset indent\n";
  for (const std::string& example : command.examples)
    text += escaped(example) + "\n";
  return text + ".Ed\n";
}

/// Writes references to the pages of the parent, the subcommands and the program.
std::string see_also(const Place& place) {
  std::vector<std::string> pages;
  const std::string own = joined(place.words, '-');
  if (place.words.size() > 1) {
    pages.push_back(place.words.front());
    pages.push_back(joined({place.words.begin(), place.words.end() - 1}, '-'));
  }
  for (const Command& below : place.command->commands)
    pages.push_back(own + "-" + below.name);
  std::sort(pages.begin(), pages.end());
  pages.erase(std::unique(pages.begin(), pages.end()), pages.end());
  if (pages.empty()) return "";
  std::string text = ".Sh SEE ALSO\n";
  for (std::size_t i = 0; i < pages.size(); ++i)
    text += fmt::format(".Xr {} 1{}\n", pages[i], i + 1 < pages.size() ? " ," : "");
  return text;
}

std::string text_of(const Place& place, const std::string& date) {
  const Command& command = *place.command;
  const std::string name = joined(place.words, '-');
  std::string title = name;
  for (char& c : title)
    c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string text = fmt::format(".Dd {}\n.Dt {} 1\n.Os\n.Sh NAME\n.Nm {}\n.Nd {}\n", date, title,
                                 name, escaped(description(command.summary, place.words.front())));
  text += synopsis(place);
  text += ".Sh DESCRIPTION\n" + wrapped(sentence(command.summary));
  for (const std::string& paragraph : command.paragraphs)
    text += ".Pp\n" + wrapped(sentence(paragraph));
  text += arguments(command);
  if (!command.exit_codes.empty()) text += ".Sh EXIT STATUS\n" + wrapped(command.exit_codes);
  return text + examples(command) + see_also(place);
}

}  // namespace

std::vector<ManPage> man_pages(const Command& program, const std::string& date) {
  std::vector<ManPage> pages;
  for (const Place& place : places_of(program))
    pages.push_back({joined(place.words, '-') + ".1", text_of(place, date)});
  return pages;
}

}  // namespace sleight::command_tree
