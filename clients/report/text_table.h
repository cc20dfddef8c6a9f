// Formats aligned columns of text and fits them to a terminal's width.
//
// If a table doesn't fit, columns are omitted, beginning with the highest rank. If the table is
// still too wide, texts in the last column are cut. Each character counts as one column of the
// terminal. Columns without any text are omitted. Pure; thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace sleight::report {

struct Column {
  std::string head{};
  bool to_the_right = false;  ///< aligned to the right, for numbers
  int rank = 0;               ///< 0: never omitted
};

struct TextTable {
  std::size_t indent = 0;  ///< spaces before each line
  std::vector<Column> columns{};
  std::vector<std::vector<std::string>> rows{};  ///< one text per column, safe for a terminal
};

/// Minimum width of the last column.
inline constexpr std::size_t k_last_column_min = 16;

/// Returns lines with line breaks, the heads first. Without a width, nothing is omitted or cut.
std::string to_text(const TextTable& table, std::optional<std::size_t> width);

}  // namespace sleight::report
