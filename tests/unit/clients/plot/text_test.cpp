#include "clients/plot/text.h"

#include <gtest/gtest.h>

namespace sleight::plot {
namespace {

TEST(Text, IsRepairedToPrintableUtf8) {
  // Goal: printable() turns any bytes into text that is safe in XML and on terminals. Method:
  // convert valid text, invalid bytes, overlong encodings, surrogates and control characters. Valid
  // text must stay unchanged.
  EXPECT_EQ(printable("σ ≤ 0.1 D 🎲"), "σ ≤ 0.1 D 🎲");
  EXPECT_EQ(printable("a\tb\nc"), "a b c");
  EXPECT_EQ(printable("\x1b[31m"), "\uFFFD[31m");
  EXPECT_EQ(printable("\xFFz"), "\uFFFDz");
  EXPECT_EQ(printable("\xC0\xAF"), "\uFFFD\uFFFD");
  EXPECT_EQ(printable("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(printable("\xF4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(printable("\xEF\xBF\xBF"), "\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(printable("\xC2\x9B"
                      "1m"),
            "\uFFFD1m");
  EXPECT_EQ(printable("cut \xE2\x88"), "cut \uFFFD\uFFFD");
}

TEST(Text, IsCountedAndCutByCodePoints) {
  // Goal: text is counted and cut in whole characters, even if a character has several bytes.
  EXPECT_EQ(length_of("±σ1"), 3U);
  EXPECT_EQ(first_of("±σ1", 2), "±σ");
  EXPECT_EQ(first_of("±σ1", 9), "±σ1");
  EXPECT_EQ(first_of("±σ1", 0), "");
}

TEST(Text, FitsItsWidth) {
  // Goal: if a text is cut to a width, the rest fits the width and begins as the text does.
  const std::string long_text = "The horizontal resting position of each sample";
  EXPECT_EQ(fitted(long_text, 12, 1000), long_text);
  for (const double width : {200.0, 90.0, 30.0}) {
    const std::string cut = fitted(long_text, 12, width);
    EXPECT_LE(text_width_px(cut, 12), width);
    EXPECT_TRUE(cut.starts_with("T"));
    EXPECT_TRUE(cut.ends_with("…"));
  }
  EXPECT_EQ(fitted(long_text, 12, 0), "…");
  EXPECT_GT(text_width_px("abc", 12, Weight::bold), text_width_px("abc", 12));
}

TEST(Text, HasAnAsciiForm) {
  // Goal: labels stay readable when they are converted to ASCII.
  EXPECT_EQ(to_ascii("−1.5×10⁻⁹"), "-1.5e-9");
  EXPECT_EQ(to_ascii("σ = ±10°"), "sigma = +-10deg");
  EXPECT_EQ(to_ascii("Ж🎲"), "??");
}

}  // namespace
}  // namespace sleight::plot
