#include "clients/plot/notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "common/base/error.h"

namespace sleight::plot {

namespace {

constexpr std::string_view k_letters = "abcdefghijklmnopqrstuvwxyz_";

bool is_control(char c) {
  const auto code = static_cast<unsigned char>(c);
  return code < 0x20 || code == 0x7F;
}

}  // namespace

Notes notes_of(std::span<const std::string> texts) {
  Notes notes;
  for (const std::string& text : texts) {
    const std::size_t end = text.find('=');
    if (end == std::string::npos || end == 0 || end + 1 == text.size() ||
        text.find_first_not_of(k_letters) != end || std::ranges::any_of(text, is_control)) {
      throw base::Error(base::ExitCode::usage,
                        fmt::format("--note '{}': expected NAME=VALUE, where NAME has letters a to "
                                    "z and underscores only, and VALUE is one line",
                                    text));
    }
    Note note{.name = text.substr(0, end), .value = text.substr(end + 1)};
    if (std::ranges::count(notes, note.name, &Note::name) > 0) {
      throw base::Error(base::ExitCode::usage,
                        fmt::format("--note '{}': there are two notes named {}", text, note.name));
    }
    notes.push_back(std::move(note));
  }
  return notes;
}

}  // namespace sleight::plot
