#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "clients/plot/terminal.h"
#include "common/base/terminal.h"

namespace sleight::plot {

namespace {

std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Returns the first non-empty variable in the order of precedence (POSIX).
std::string_view locale_name() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    if (!environment(name).empty()) return environment(name);
  }
  return "";
}

}  // namespace

bool names_utf8(std::string_view locale) {
  std::string lower(locale);
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower.find(".utf-8") != std::string::npos || lower.find(".utf8") != std::string::npos;
}

TerminalOptions detect_terminal(int file_descriptor) {
  TerminalOptions options;
  options.unicode = names_utf8(locale_name());
  const auto terminal = base::terminal_at(file_descriptor);
  if (!terminal) return options;
  options.columns = terminal->columns;
  // Leave a row for the next prompt.
  options.rows = terminal->rows - 1;
  options.color = environment("NO_COLOR").empty() && terminal->has_escapes;
  return options;
}

}  // namespace sleight::plot
