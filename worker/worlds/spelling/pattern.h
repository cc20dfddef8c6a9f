// Which bins shall hold a ball: a picture of rows and columns, from a word or from rows of '.' and
// '#'.
//
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/result.h"

namespace sleight::worlds::spelling {

struct Pattern {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::vector<std::uint8_t> designated;  ///< row by row from the top, 1 or 0

  bool at(std::uint32_t column, std::uint32_t row) const {
    return designated[row * columns + column] != 0;
  }
  /// How many bins are designated.
  std::uint32_t count() const;
  friend bool operator==(const Pattern&, const Pattern&) = default;
};

/// Heights of the letters that the program has.
enum class Font : std::uint8_t { rows_5 = 5, rows_7 = 7 };

/// Rows of '.' and '#', equally long, one line each; empty lines at both ends are left out. An
/// error says which line is wrong, and why.
base::Result<Pattern, std::string> pattern_of_rows(std::string_view rows);

/// Letters A to Z, small or not, digits and spaces, a column apart, with a ring of empty bins
/// around. An error names the first character that has no picture.
base::Result<Pattern, std::string> pattern_of_word(std::string_view word, Font font);

/// The same picture in the middle of a larger grid, nearer to the left and the top if it can't be
/// in the very middle. REQUIRES: it fits.
Pattern centred(const Pattern& pattern, std::uint32_t columns, std::uint32_t rows);

/// The thesis's HI: ten bins of seven by five (figure 2.7).
Pattern hi();

}  // namespace sleight::worlds::spelling
