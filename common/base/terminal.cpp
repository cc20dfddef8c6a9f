#include "common/base/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace sleight::base {

std::optional<Terminal> terminal_at(int file_descriptor) {
  if (::isatty(file_descriptor) != 1) return std::nullopt;
  Terminal terminal;
  winsize size{};
  if (::ioctl(file_descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0) {
    terminal.columns = size.ws_col;
    terminal.rows = size.ws_row;
  }
  const char* const kind = std::getenv("TERM");
  terminal.has_escapes = kind != nullptr && *kind != '\0' && std::string_view(kind) != "dumb";
  return terminal;
}

}  // namespace sleight::base
