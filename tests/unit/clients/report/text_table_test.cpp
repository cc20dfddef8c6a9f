#include "clients/report/text_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "common/request/text.h"

namespace sleight::report {
namespace {

TextTable example() {
  return {.columns = {{.head = "ID", .to_the_right = true},
                      {.head = "NAME", .rank = 1},
                      {.head = "NONE", .rank = 1},
                      {.head = "RATE", .to_the_right = true, .rank = 2},
                      {.head = "WHY", .rank = 1}},
          .rows = {{"7", "hi", "", "85,200", "waits for four cores that others have"},
                   {"1234", "für", "", "", ""}}};
}

std::size_t longest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t longest = 0;
  for (std::string line; std::getline(lines, line);)
    longest = std::max(longest, request::character_count(line));
  return longest;
}

TEST(TextTable, AlignsColumnsAndLeavesEmptyOnesOut) {
  // Goal: a table aligns numbers to the right and texts to the left, and omits empty columns.
  // Widths are counted in characters, not bytes.
  EXPECT_EQ(to_text(example(), std::nullopt),
            "  ID  NAME    RATE  WHY\n"
            "   7  hi    85,200  waits for four cores that others have\n"
            "1234  für\n");
}

TEST(TextTable, FitsEveryWidth) {
  // Goal: no line is wider than the terminal. A narrow table omits its least important column
  // first.
  const TextTable table = example();
  for (std::size_t width = 10; width < 80; ++width) {
    const std::string text = to_text(table, width);
    EXPECT_LE(longest_line(text), width) << text;
    EXPECT_NE(text.find("1234"), std::string::npos);
    if (text.find("NAME") == std::string::npos) {
      EXPECT_EQ(text.find("RATE"), std::string::npos) << text;
    }
  }
  EXPECT_EQ(to_text(table, 40),
            "  ID  NAME    RATE  WHY\n"
            "   7  hi    85,200  waits for four co...\n"
            "1234  für\n");
}

TEST(TextTable, OfNothingIsNothing) {
  // Goal: a table without rows prints nothing, not even the column heads.
  EXPECT_EQ(to_text({.columns = {{.head = "ID"}}, .rows = {}}, 80), "");
}

}  // namespace
}  // namespace sleight::report
