#include "worker/worlds/spelling/pattern.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "common/base/check.h"
#include "common/request/text.h"

namespace sleight::worlds::spelling {
namespace {

/// The rows of a character, from top to bottom. The highest bit of a row is the leftmost column.
struct Glyph {
  char character;
  std::uint8_t width;
  std::array<std::uint8_t, 7> rows;
};

constexpr Glyph k_five[] = {
    {'A', 3, {0b010, 0b101, 0b111, 0b101, 0b101}},
    {'B', 3, {0b110, 0b101, 0b110, 0b101, 0b110}},
    {'C', 3, {0b011, 0b100, 0b100, 0b100, 0b011}},
    {'D', 3, {0b110, 0b101, 0b101, 0b101, 0b110}},
    {'E', 3, {0b111, 0b100, 0b110, 0b100, 0b111}},
    {'F', 3, {0b111, 0b100, 0b110, 0b100, 0b100}},
    {'G', 4, {0b0111, 0b1000, 0b1011, 0b1001, 0b0111}},
    {'H', 3, {0b101, 0b101, 0b111, 0b101, 0b101}},
    {'I', 1, {0b1, 0b1, 0b1, 0b1, 0b1}},
    {'J', 3, {0b001, 0b001, 0b001, 0b101, 0b010}},
    {'K', 3, {0b101, 0b101, 0b110, 0b101, 0b101}},
    {'L', 3, {0b100, 0b100, 0b100, 0b100, 0b111}},
    {'M', 5, {0b10001, 0b11011, 0b10101, 0b10001, 0b10001}},
    {'N', 4, {0b1001, 0b1101, 0b1011, 0b1001, 0b1001}},
    {'O', 3, {0b010, 0b101, 0b101, 0b101, 0b010}},
    {'P', 3, {0b110, 0b101, 0b110, 0b100, 0b100}},
    {'Q', 4, {0b0110, 0b1001, 0b1001, 0b1010, 0b0101}},
    {'R', 3, {0b110, 0b101, 0b110, 0b101, 0b101}},
    {'S', 3, {0b111, 0b100, 0b010, 0b001, 0b111}},
    {'T', 3, {0b111, 0b010, 0b010, 0b010, 0b010}},
    {'U', 3, {0b101, 0b101, 0b101, 0b101, 0b111}},
    {'V', 3, {0b101, 0b101, 0b101, 0b101, 0b010}},
    {'W', 5, {0b10001, 0b10001, 0b10101, 0b11011, 0b10001}},
    {'X', 3, {0b101, 0b101, 0b010, 0b101, 0b101}},
    {'Y', 3, {0b101, 0b101, 0b010, 0b010, 0b010}},
    {'Z', 3, {0b111, 0b001, 0b010, 0b100, 0b111}},
    {'0', 3, {0b111, 0b101, 0b101, 0b101, 0b111}},
    {'1', 2, {0b01, 0b11, 0b01, 0b01, 0b01}},
    {'2', 3, {0b111, 0b001, 0b111, 0b100, 0b111}},
    {'3', 3, {0b111, 0b001, 0b011, 0b001, 0b111}},
    {'4', 3, {0b101, 0b101, 0b111, 0b001, 0b001}},
    {'5', 3, {0b111, 0b100, 0b111, 0b001, 0b111}},
    {'6', 3, {0b111, 0b100, 0b111, 0b101, 0b111}},
    {'7', 3, {0b111, 0b001, 0b010, 0b010, 0b010}},
    {'8', 3, {0b111, 0b101, 0b111, 0b101, 0b111}},
    {'9', 3, {0b111, 0b101, 0b111, 0b001, 0b111}},
    {' ', 2, {}},
};

constexpr Glyph k_seven[] = {
    {'A', 5, {0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001}},
    {'B', 5, {0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110}},
    {'C', 5, {0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110}},
    {'D', 5, {0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110}},
    {'E', 5, {0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111}},
    {'F', 5, {0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000}},
    {'G', 5, {0b01110, 0b10001, 0b10000, 0b10111, 0b10001, 0b10001, 0b01111}},
    {'H', 5, {0b10001, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001}},
    {'I', 3, {0b111, 0b010, 0b010, 0b010, 0b010, 0b010, 0b111}},
    {'J', 5, {0b00111, 0b00010, 0b00010, 0b00010, 0b00010, 0b10010, 0b01100}},
    {'K', 5, {0b10001, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010, 0b10001}},
    {'L', 5, {0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111}},
    {'M', 5, {0b10001, 0b11011, 0b10101, 0b10101, 0b10001, 0b10001, 0b10001}},
    {'N', 5, {0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001, 0b10001}},
    {'O', 5, {0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'P', 5, {0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000}},
    {'Q', 5, {0b01110, 0b10001, 0b10001, 0b10001, 0b10101, 0b10010, 0b01101}},
    {'R', 5, {0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001}},
    {'S', 5, {0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110}},
    {'T', 5, {0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100}},
    {'U', 5, {0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'V', 5, {0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100}},
    {'W', 5, {0b10001, 0b10001, 0b10001, 0b10101, 0b10101, 0b11011, 0b10001}},
    {'X', 5, {0b10001, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001, 0b10001}},
    {'Y', 5, {0b10001, 0b10001, 0b01010, 0b00100, 0b00100, 0b00100, 0b00100}},
    {'Z', 5, {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b11111}},
    {'0', 5, {0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110}},
    {'1', 3, {0b010, 0b110, 0b010, 0b010, 0b010, 0b010, 0b111}},
    {'2', 5, {0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111}},
    {'3', 5, {0b11110, 0b00001, 0b00001, 0b01110, 0b00001, 0b00001, 0b11110}},
    {'4', 5, {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010}},
    {'5', 5, {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110}},
    {'6', 5, {0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110}},
    {'7', 5, {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000}},
    {'8', 5, {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110}},
    {'9', 5, {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100}},
    {' ', 3, {}},
};

const Glyph* glyph_of(char character, Font font) {
  const char large =
      character >= 'a' && character <= 'z' ? static_cast<char>(character - 'a' + 'A') : character;
  const auto find = [&](const auto& glyphs) -> const Glyph* {
    for (const Glyph& glyph : glyphs) {
      if (glyph.character == large) return &glyph;
    }
    return nullptr;
  };
  return font == Font::rows_5 ? find(k_five) : find(k_seven);
}

/// Returns the first character in a printable form.
std::string character_at(std::string_view text) {
  const auto first = request::front_code_point(text);
  return request::printable(text.substr(0, first ? first->bytes : 1), 8);
}

Pattern empty_pattern(std::uint32_t columns, std::uint32_t rows) {
  return {.columns = columns,
          .rows = rows,
          .designated = std::vector<std::uint8_t>(std::size_t{columns} * rows)};
}

}  // namespace

std::uint32_t Pattern::count() const {
  return std::accumulate(designated.begin(), designated.end(), 0U);
}

base::Result<Pattern, std::string> pattern_of_rows(std::string_view rows) {
  std::vector<std::string_view> lines;
  for (std::size_t begin = 0; begin <= rows.size();) {
    const std::size_t end = std::min(rows.find('\n', begin), rows.size());
    std::string_view line = rows.substr(begin, end - begin);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    lines.push_back(line);
    begin = end + 1;
  }
  while (!lines.empty() && lines.back().empty())
    lines.pop_back();
  while (!lines.empty() && lines.front().empty())
    lines.erase(lines.begin());
  if (lines.empty()) return std::string("the pattern has no rows");
  Pattern pattern = empty_pattern(static_cast<std::uint32_t>(lines.front().size()),
                                  static_cast<std::uint32_t>(lines.size()));
  for (std::size_t row = 0; row < lines.size(); ++row) {
    const std::string of_row = "row " + std::to_string(row + 1);
    if (lines[row].size() != pattern.columns) {
      return of_row + " has " + std::to_string(lines[row].size()) + " characters, but row 1 has " +
             std::to_string(pattern.columns);
    }
    for (std::size_t column = 0; column < pattern.columns; ++column) {
      const char character = lines[row][column];
      if (character != '.' && character != '#') {
        return of_row + " has '" + character_at(lines[row].substr(column)) + "' in column " +
               std::to_string(column + 1) + "; use only '.' and '#'";
      }
      pattern.designated[row * pattern.columns + column] = character == '#' ? 1 : 0;
    }
  }
  return pattern;
}

base::Result<Pattern, std::string> pattern_of_word(std::string_view word, Font font) {
  if (word.empty()) return std::string("the word has no letters");
  std::vector<const Glyph*> glyphs;
  std::uint32_t width = 0;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const Glyph* glyph = glyph_of(word[i], font);
    if (glyph == nullptr) {
      return "the font has no '" + character_at(word.substr(i)) +
             "'; use A to Z, 0 to 9 and spaces, or a bitmap";
    }
    glyphs.push_back(glyph);
    width += glyph->width + 1;
  }
  // Characters are one column apart. A ring of empty bins surrounds the word.
  const auto height = static_cast<std::uint32_t>(font);
  Pattern pattern = empty_pattern(width + 1, height + 2);
  std::uint32_t left = 1;
  for (const Glyph* glyph : glyphs) {
    for (std::uint32_t row = 0; row < height; ++row) {
      for (std::uint32_t column = 0; column < glyph->width; ++column) {
        const bool set = (glyph->rows[row] >> (glyph->width - 1U - column) & 1U) != 0;
        pattern.designated[(row + 1) * pattern.columns + left + column] = set ? 1 : 0;
      }
    }
    left += glyph->width + 1U;
  }
  return pattern;
}

Pattern centred(const Pattern& pattern, std::uint32_t columns, std::uint32_t rows) {
  CHECK_GE(columns, pattern.columns);
  CHECK_GE(rows, pattern.rows);
  Pattern larger = empty_pattern(columns, rows);
  const std::uint32_t left = (columns - pattern.columns) / 2;
  const std::uint32_t top = (rows - pattern.rows) / 2;
  for (std::uint32_t row = 0; row < pattern.rows; ++row) {
    for (std::uint32_t column = 0; column < pattern.columns; ++column) {
      larger.designated[(top + row) * columns + left + column] =
          pattern.designated[row * pattern.columns + column];
    }
  }
  return larger;
}

Pattern hi() {
  return pattern_of_rows(
             ".......\n"
             ".#.#.#.\n"
             ".###.#.\n"
             ".#.#.#.\n"
             ".......")
      .value();
}

}  // namespace sleight::worlds::spelling
