// Columns of text, aligned, and fitted to a terminal's width.
//
// Where the whole does not fit, columns are left out, those of the highest rank first; then the
// last column loses the ends of its texts. Characters count as one column each. A column without
// any text is left out.
//
// Pure; thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace sleight::report {

struct Column {
  std::string head{};
  bool to_the_right = false;  ///< as numbers are written
  int rank = 0;               ///< 0: is never left out
};

struct TextTable {
  std::size_t indent = 0;  ///< spaces before each line
  std::vector<Column> columns{};
  std::vector<std::vector<std::string>> rows{};  ///< one text a column each, fit for a terminal
};

/// The last column is cut to no less than this; before that, others are left out.
inline constexpr std::size_t k_last_column_min = 16;

/// Lines, each with its end; the heads first. Without a width nothing is left out or cut.
std::string to_text(const TextTable& table, std::optional<std::size_t> width);

}  // namespace sleight::report
