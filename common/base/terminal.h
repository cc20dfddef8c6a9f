// The properties of a file descriptor's terminal.
#pragma once

#include <cstddef>
#include <optional>

namespace sleight::base {

struct Terminal {
  std::size_t columns = 80;  ///< 80 x 24 if unknown
  std::size_t rows = 24;
  bool has_escapes = false;  ///< supports ANSI escape codes: TERM is set and not "dumb"
};

/// Returns nothing if the descriptor is not a terminal. Reads the environment.
std::optional<Terminal> terminal_at(int file_descriptor);

}  // namespace sleight::base
