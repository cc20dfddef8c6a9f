// A pattern in which every bin is designated.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/worlds/spelling/pattern.h"

namespace sleight::worlds::spelling {

inline Pattern full_pattern(std::uint32_t columns, std::uint32_t rows) {
  return {.columns = columns,
          .rows = rows,
          .designated = std::vector<std::uint8_t>(std::size_t{columns} * rows, 1)};
}

}  // namespace sleight::worlds::spelling
