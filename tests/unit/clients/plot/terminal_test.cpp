#include "clients/plot/terminal.h"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "clients/plot/text.h"
#include "tests/unit/clients/plot/examples.h"

namespace sleight::plot {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    lines.push_back(line);
  return lines;
}

TEST(Terminal, NeverExceedsItsSize) {
  // Goal: a terminal picture is never larger than requested, or than the minimum size if less is
  // requested. Method: draw all example panels at many sizes, with and without Unicode. Count the
  // lines and their characters.
  for (const Figure& figure : {landing_figure(), paths_figure(), hostile_figure()}) {
    for (const Panel& panel : figure.panels) {
      for (const std::size_t columns : {1U, 24U, 40U, 80U, 200U}) {
        for (const std::size_t rows : {1U, 6U, 9U, 24U, 60U}) {
          for (const bool unicode : {false, true}) {
            const std::string text = to_terminal(panel, {columns, rows, unicode, false});
            const auto lines = lines_of(text);
            ASSERT_LE(lines.size(), std::max<std::size_t>(rows, 6));
            for (const std::string& line : lines) {
              ASSERT_LE(length_of(line), std::max<std::size_t>(columns, 24)) << line;
              ASSERT_FALSE(line.ends_with(' ')) << line;
            }
          }
        }
      }
    }
  }
}

TEST(Terminal, IsPureAsciiWhereAsked) {
  // Goal: without Unicode and colours, the picture consists of plain ASCII characters.
  for (const Panel& panel : hostile_figure().panels) {
    for (const char c : to_terminal(panel, {.unicode = false})) {
      ASSERT_TRUE((c >= ' ' && c <= '~') || c == '\n') << static_cast<int>(c);
    }
  }
}

TEST(Terminal, DrawsARisingLine) {
  // Goal: the ASCII picture of a diagonal line on the smallest canvas has exactly the expected
  // characters.
  const Panel panel{.x_range = Range{0, 10},
                    .y_range = Range{0, 1},
                    .series = {Line{.points = {{0, 0}, {10, 1}}}}};
  const std::string expected =
      "1 +                ...''\n"
      "  |           ..'''\n"
      "  |     ...'''\n"
      "0 +..'''\n"
      "  ++-------------------+\n"
      "   0                  10\n";
  EXPECT_EQ(to_terminal(panel, {.columns = 24, .rows = 6, .unicode = false}), expected);
}

TEST(Terminal, UsesBraille) {
  // Goal: each marker sets the right dot of the right braille character. Method: draw a marker in
  // each corner.
  const Panel panel{.x_range = Range{0, 1},
                    .y_range = Range{0, 1},
                    .series = {Markers{.points = {{0, 0}, {0, 1}, {1, 0}, {1, 1}}}}};
  const auto lines = lines_of(to_terminal(panel, {.columns = 24, .rows = 6}));
  EXPECT_NE(lines[0].find("⠁"), std::string::npos) << lines[0];
  EXPECT_TRUE(lines[0].ends_with("⠈")) << lines[0];
  EXPECT_NE(lines[3].find("⡀"), std::string::npos) << lines[3];
  EXPECT_TRUE(lines[3].ends_with("⢀")) << lines[3];
}

TEST(Terminal, DrawsVerticalLines) {
  // Goal: a vertical line spans the whole height of the panel at the line's x value.
  const Panel panel{.x_range = Range{0, 1},
                    .y_range = Range{0, 1},
                    .series = {VerticalLine{.x = 1, .dashed = false}}};
  const auto lines = lines_of(to_terminal(panel, {.columns = 24, .rows = 6}));
  for (int row = 0; row < 4; ++row)
    EXPECT_TRUE(lines[static_cast<std::size_t>(row)].ends_with("⢸")) << lines[0];
}

TEST(Terminal, MarksInfinitiesAndSurvivesNothing) {
  // Goal: a point at minus infinity is drawn as an arrow, and an empty panel contains no arrow.
  const Panel panel{
      .series = {Line{.points = {{0, 0}, {1, -std::numeric_limits<double>::infinity()}, {2, 1}}}}};
  EXPECT_NE(to_terminal(panel, {}).find("↓"), std::string::npos);
  EXPECT_EQ(to_terminal(Panel{}, {}).find("↓"), std::string::npos);
}

TEST(Terminal, ColorsAndResets) {
  // Goal: the picture has colours only on request. Each coloured line ends with the code that
  // resets the terminal's colour.
  const Panel panel{.series = {Line{.points = {{0, 0}, {1, 1}}}}};
  EXPECT_EQ(to_terminal(panel, {}).find('\x1b'), std::string::npos);
  const std::string colored = to_terminal(panel, {.color = true});
  EXPECT_NE(colored.find("\x1b[38;5;"), std::string::npos);
  for (const std::string& line : lines_of(colored)) {
    EXPECT_EQ(line.find('\x1b') != std::string::npos, line.ends_with("\x1b[39m")) << line;
  }
}

TEST(Terminal, KnowsUtf8Locales) {
  // Goal: the terminal counts as a Unicode terminal only if the name of its locale contains
  // ".UTF-8" or ".utf8".
  EXPECT_TRUE(names_utf8("en_GB.UTF-8"));
  EXPECT_TRUE(names_utf8("C.utf8"));
  EXPECT_FALSE(names_utf8("C"));
  EXPECT_FALSE(names_utf8(""));
  EXPECT_FALSE(names_utf8("de_DE.ISO-8859-1"));
}

TEST(Terminal, TakesAFileForNoTerminal) {
  // Goal: if output doesn't go to a terminal, it has the default size and no colours. Method: use
  // an invalid file descriptor.
  const TerminalOptions options = detect_terminal(-1);
  EXPECT_EQ(options.columns, 80U);
  EXPECT_EQ(options.rows, 24U);
  EXPECT_FALSE(options.color);
}

}  // namespace
}  // namespace sleight::plot
