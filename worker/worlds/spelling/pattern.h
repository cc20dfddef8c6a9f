// A pattern is a picture of the bins that shall hold a ball. A pattern is made from a word, or from
// rows of '.' and '#'.
// Thread safety: values and pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
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
  std::uint32_t count() const;
  friend bool operator==(const Pattern&, const Pattern&) = default;
};

enum class Font : std::uint8_t { rows_5 = 5, rows_7 = 7 };

/// Reads rows of '.' and '#'. Each line is a row; all rows are equally long. Ignores empty lines at
/// both ends. An error names the faulty line and the reason.
base::Result<Pattern, std::string> pattern_of_rows(std::string_view rows);

/// Draws upper- or lower-case letters, digits and spaces. Characters are one column apart. A ring
/// of empty bins surrounds the word. If characters have no picture, the error names the first such
/// character.
base::Result<Pattern, std::string> pattern_of_word(std::string_view word, Font font);

/// Returns the picture in the middle of a larger grid. If the exact middle is impossible, the
/// picture is one bin nearer to the left or the top. REQUIRES: the picture fits.
Pattern centred(const Pattern& pattern, std::uint32_t columns, std::uint32_t rows);

/// Returns the thesis's HI: ten bins of seven by five (figure 2.7).
Pattern hi();

}  // namespace sleight::worlds::spelling
