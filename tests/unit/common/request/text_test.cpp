// Goal: printed text is harmless on a terminal. If a text or a number is written as TOML, it reads
// back exactly. Method: use examples of each class of characters. For numbers, write and read
// random bit patterns.
#include "common/request/text.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace sleight::request {
namespace {

TEST(FrontCodePoint, DecodesEachLength) {
  EXPECT_EQ(front_code_point("a")->value, U'a');
  EXPECT_EQ(front_code_point("\xc3\xa4")->value, U'\u00e4');
  EXPECT_EQ(front_code_point("\xe2\x82\xac")->value, U'\u20ac');
  EXPECT_EQ(front_code_point("\xf0\x9f\x8e\xb2")->value, U'\U0001f3b2');
  EXPECT_EQ(front_code_point("\xf0\x9f\x8e\xb2z")->bytes, 4U);
}

TEST(FrontCodePoint, RefusesWhatIsNotUtf8) {
  for (const std::string_view bad :
       {"\x80", "\xff", "\xc3", "\xc3z", "\xe2\x82", "\xc0\x80", "\xc1\xbf", "\xe0\x80\x80",
        "\xed\xa0\x80", "\xf0\x80\x80\x80", "\xf4\x90\x80\x80", "\xf8\x88\x80\x80\x80"}) {
    EXPECT_FALSE(front_code_point(bad).has_value());
  }
}

TEST(Printable, EscapesWhatATerminalWouldActOn) {
  EXPECT_EQ(printable("plain \"text\" \xc3\xa4", 99), "plain \"text\" \xc3\xa4");
  EXPECT_EQ(printable("\x1b[2J\a\n\t\x7f", 99), "\\u{1b}[2J\\u{7}\\u{a}\\u{9}\\u{7f}");
  EXPECT_EQ(printable("\xc2\x9b", 99), "\\u{9b}");        // C1: control sequence introducer
  EXPECT_EQ(printable("\xe2\x80\xae", 99), "\\u{202e}");  // right-to-left override
  EXPECT_EQ(printable("a\xff\xc3", 99), "a\\xff\\xc3");   // not UTF-8
  EXPECT_EQ(printable(std::string_view("\0", 1), 99), "\\u{0}");
}

TEST(Printable, CutsByCharacters) {
  EXPECT_EQ(printable("abcd", 4), "abcd");
  EXPECT_EQ(printable("abcde", 4), "abcd...");
  EXPECT_EQ(printable("\xc3\xa4\xc3\xa4\xc3\xa4", 2), "\xc3\xa4\xc3\xa4...");
}

TEST(TomlNumber, IsAFloatOfFewestDigits) {
  EXPECT_EQ(toml_number(4), "4.0");
  EXPECT_EQ(toml_number(-0.1), "-0.1");
  EXPECT_EQ(toml_number(1e-6), "1e-6");
  EXPECT_EQ(toml_number(1e-10), "1e-10");
  EXPECT_EQ(toml_number(1e22), "1e+22");
  EXPECT_EQ(toml_number(0.70710678118654752), "0.7071067811865476");
  EXPECT_EQ(plain_number(std::nan("")), "nan");
}

TEST(TomlNumber, ReadsBackToTheSameBits) {
  std::uint64_t bits = 1;
  for (int i = 0; i < 100000; ++i) {
    bits = bits * 6364136223846793005U + 1442695040888963407U;
    const double value = std::bit_cast<double>(bits);
    if (!std::isfinite(value)) continue;
    const std::string text = toml_number(value);
    double back = 0;
    std::from_chars(text.data(), text.data() + text.size(), back);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(back), bits) << text;
    ASSERT_NE(text.find_first_of(".e"), std::string::npos) << text;
  }
}

TEST(TomlString, EscapesQuotesAndControls) {
  EXPECT_EQ(toml_string("a\"b\\c"), R"("a\"b\\c")");
  EXPECT_EQ(toml_string("\n\x7f"), R"("\U0000000A\U0000007F")");
  EXPECT_EQ(toml_string("\xc3\xa4"), "\"\xc3\xa4\"");
}

TEST(Degrees, HaveAShortForm) {
  EXPECT_EQ(degrees_of_radians(0.17453292519943295), 10);
  EXPECT_EQ(degrees_of_radians(0.087266462599716474), 5);
  EXPECT_EQ(radians_of_degrees(10), 0.17453292519943295);
  EXPECT_EQ(degrees_of_radians(0), 0);
  for (int tenths = -1800; tenths <= 1800; ++tenths) {
    const double degrees = tenths / 10.0;
    ASSERT_EQ(degrees_of_radians(radians_of_degrees(degrees)), degrees);
  }
}

}  // namespace
}  // namespace sleight::request
