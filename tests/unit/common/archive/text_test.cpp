// Goal: texts with control characters or invalid UTF-8 are recognised. Method: use valid and
// invalid sequences from RFC 3629.
#include "common/archive/text.h"

#include <gtest/gtest.h>

#include <string>

namespace sleight::archive {
namespace {

using namespace std::string_view_literals;

TEST(Text, CleanLines) {
  for (const std::string_view text :
       {""sv, "plain ~"sv, "sch\xC3\xB6n"sv, "\xE2\x82\xAC"sv, "\xF0\x9F\x8E\xB1"sv, "\xC2\xA0"sv,
        "\xED\x9F\xBF"sv, "\xEE\x80\x80"sv, "\xF4\x8F\xBF\xBF"sv}) {
    EXPECT_TRUE(is_clean_line(text)) << text;
    EXPECT_TRUE(is_clean_text(text)) << text;
  }
}

TEST(Text, ControlCharactersAndBrokenUtf8) {
  for (const std::string_view text :
       {"\x1B[2J"sv, "a\0b"sv, "\r"sv, "\x7F"sv, "\xC2\x9B"sv, "\x80"sv, "a\xC3"sv, "\xC3("sv,
        "\xC0\xAF"sv, "\xE0\x80\xAF"sv, "\xF0\x80\x80\xAF"sv, "\xED\xA0\x80"sv,
        "\xF4\x90\x80\x80"sv, "\xFF"sv}) {
    EXPECT_FALSE(is_clean_line(text));
    EXPECT_FALSE(is_clean_text(text));
  }
}

TEST(Text, LinesAndTabsOnlyInTexts) {
  EXPECT_FALSE(is_clean_line("a\nb"));
  EXPECT_FALSE(is_clean_line("a\tb"));
  EXPECT_TRUE(is_clean_text("a\n\tb\n"));
}

}  // namespace
}  // namespace sleight::archive
