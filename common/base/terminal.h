// What a file descriptor's terminal is and can do; asked here alone.
#pragma once

#include <cstddef>
#include <optional>

namespace sleight::base {

struct Terminal {
  std::size_t columns = 80;  ///< 80 x 24 where the terminal doesn't say
  std::size_t rows = 24;
  bool has_escapes = false;  ///< ANSI escape codes: TERM is neither unset nor "dumb"
};

/// None: it is no terminal. Reads the environment.
std::optional<Terminal> terminal_at(int file_descriptor);

}  // namespace sleight::base
