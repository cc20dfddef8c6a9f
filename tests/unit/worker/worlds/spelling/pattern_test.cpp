#include "worker/worlds/spelling/pattern.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sleight::worlds::spelling {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string rows_of(const Pattern& pattern) {
  std::string text;
  for (std::uint32_t row = 0; row < pattern.rows; ++row) {
    for (std::uint32_t column = 0; column < pattern.columns; ++column)
      text += pattern.at(column, row) ? '#' : '.';
    text += '\n';
  }
  return text;
}

TEST(Pattern, TheThesisExamples) {
  // Goal: the pattern of HI has ten bins in a grid of 7 x 5. The pattern of ACM has thirty bins in
  // a grid of 15 x 7 (thesis figures 2.7 and 2.12).
  EXPECT_EQ(hi().columns, 7U);
  EXPECT_EQ(hi().rows, 5U);
  EXPECT_EQ(hi().count(), 10U);
  const auto acm = pattern_of_word("ACM", Font::rows_5);
  ASSERT_TRUE(acm.ok());
  EXPECT_EQ(rows_of(acm.value()),
            "...............\n"
            "..#...##.#...#.\n"
            ".#.#.#...##.##.\n"
            ".###.#...#.#.#.\n"
            ".#.#.#...#...#.\n"
            ".#.#..##.#...#.\n"
            "...............\n");
  EXPECT_EQ(acm.value().count(), 30U);
}

TEST(Pattern, RowsComeBackAsTheyWere) {
  // Goal: pattern_of_rows() reads the picture that rows of text show, with any kind of line ends.
  // Method: convert each pattern back into rows.
  const std::string rows = "#.#\n.#.\n";
  for (const std::string& text : {rows, "\n" + rows + "\n", std::string("#.#\r\n.#.\r\n")}) {
    const auto pattern = pattern_of_rows(text);
    ASSERT_TRUE(pattern.ok());
    EXPECT_EQ(rows_of(pattern.value()), rows);
  }
}

TEST(Pattern, ErrorsNameTheRowAndTheCharacter) {
  // Goal: an error about a pattern names the row, the column or the character that is wrong.
  // Method: test texts with one mistake each.
  EXPECT_THAT(pattern_of_rows("").error(), HasSubstr("no rows"));
  EXPECT_THAT(pattern_of_rows("#.\n#").error(),
              AllOf(HasSubstr("row 2 has 1 "), HasSubstr("row 1 has 2")));
  EXPECT_THAT(pattern_of_rows("#.\n.x").error(), HasSubstr("row 2 has 'x' in column 2"));
  EXPECT_THAT(pattern_of_word("", Font::rows_5).error(), HasSubstr("no letters"));
  EXPECT_THAT(pattern_of_word("A?", Font::rows_7).error(),
              AllOf(HasSubstr("no '?'"), HasSubstr("A to Z, 0 to 9 and spaces")));
}

TEST(Pattern, BothFontsHaveEveryLetterAndDigit) {
  // Goal: in both fonts, every letter and every digit has a picture of its own, without empty rows
  // or columns at its edges. Small letters have the same pictures as capital letters.
  for (const Font font : {Font::rows_5, Font::rows_7}) {
    std::vector<Pattern> seen;
    for (const char c : std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789")) {
      const auto pattern = pattern_of_word(std::string(1, c), font);
      ASSERT_TRUE(pattern.ok()) << c;
      EXPECT_EQ(pattern.value().rows, static_cast<std::uint32_t>(font) + 2) << c;
      // The first and last rows and columns of the letter aren't empty.
      const Pattern& p = pattern.value();
      std::uint32_t top = 0;
      std::uint32_t bottom = 0;
      std::uint32_t left = 0;
      std::uint32_t right = 0;
      for (std::uint32_t column = 0; column < p.columns; ++column) {
        top += p.at(column, 1) ? 1 : 0;
        bottom += p.at(column, p.rows - 2) ? 1 : 0;
      }
      for (std::uint32_t row = 0; row < p.rows; ++row) {
        left += p.at(1, row) ? 1 : 0;
        right += p.at(p.columns - 2, row) ? 1 : 0;
      }
      EXPECT_TRUE(top > 0 && bottom > 0 && left > 0 && right > 0) << c;
      for (const Pattern& other : seen)
        EXPECT_FALSE(other == p) << c;
      seen.push_back(p);
      const char small = c >= 'A' ? static_cast<char>(c - 'A' + 'a') : c;
      EXPECT_EQ(pattern_of_word(std::string(1, small), font).value(), p) << c;
    }
  }
}

TEST(Pattern, CentredKeepsThePicture) {
  // Goal: centred() puts a picture unchanged into a larger grid. Method: put HI's letters into a
  // grid of ten by six.
  const Pattern pattern = centred(hi(), 10, 6);
  EXPECT_EQ(rows_of(pattern),
            "..........\n"
            "..#.#.#...\n"
            "..###.#...\n"
            "..#.#.#...\n"
            "..........\n"
            "..........\n");
}

}  // namespace
}  // namespace sleight::worlds::spelling
