#include "common/events/run_end.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/property.h"

namespace sleight::events {
namespace {

RunEnd example() {
  return {.epoch = 3,
          .end = End::failed,
          .exit_code = base::ExitCode::environment,
          .scans = 120,
          .found = 7,
          .solutions = 2,
          .digest = "00ff",
          .words = "a.h5: \"can't\" be\nwritten: \u00e4",
          .place = "run.cpp:12"};
}

TEST(RunEnd, IsOneLineThatComesBack) {
  // Goal: the record of a run's end is written as one line and reads back equal. Method: write
  // every kind of end, with a text that contains quotes, line ends and non-ASCII letters.
  for (int kind = 0; kind <= static_cast<int>(End::bug); ++kind) {
    RunEnd end = example();
    end.end = static_cast<End>(kind);
    const std::string line = to_line(end);
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
    EXPECT_EQ(line.back(), '\n');
    EXPECT_EQ(run_end_of(line), end) << line;
    EXPECT_EQ(run_end_of(line.substr(0, line.size() - 1)), end);
  }
  EXPECT_EQ(to_line(example()),
            "{\"epoch\":3,\"end\":\"failed\",\"exit_code\":5,\"scans\":120,\"found\":7,"
            "\"solutions\":2,\"digest\":\"00ff\",\"words\":\"a.h5: \\\"can't\\\" be\\nwritten: "
            "\u00e4\",\"place\":\"run.cpp:12\"}\n");
}

TEST(RunEnd, FitsAPipe) {
  // Goal: a long text is shortened, so a record is short enough for one atomic write to a pipe.
  // Method: use texts of many lengths. A text repeats one character, which takes one to six bytes
  // in JSON or is invalid UTF-8. A shortened text must keep its beginning and its end.
  for (const char* character : {"x", "\n", "\x01", "\xff", "\u20ac"}) {
    for (const std::size_t count : {1U, 700U, 3900U, 4096U, 5000U, 100'000U}) {
      RunEnd end = example();
      end.words = "first ";
      for (std::size_t i = 0; i < count; ++i)
        end.words += character;
      end.words += " last";
      const std::string line = to_line(end);
      EXPECT_LE(line.size(), k_end_line_bytes_max);
      const auto back = run_end_of(line);
      ASSERT_TRUE(back.has_value()) << line;
      EXPECT_TRUE(back->words.starts_with("first "));
      EXPECT_TRUE(back->words.ends_with(" last"));
    }
  }
  RunEnd all_long = example();
  all_long.words = all_long.place = all_long.digest = std::string(100'000, '\n');
  EXPECT_LE(to_line(all_long).size(), k_end_line_bytes_max);
  EXPECT_TRUE(run_end_of(to_line(all_long)).has_value());
}

TEST(RunEnd, NothingElseIsOne) {
  // Goal: a damaged line never reads as the original record. Method: replace each byte of a line in
  // turn. Cut the line at each byte. Remove and add keys. Change the types of values.
  const std::string line = to_line(example());
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    std::string other = line;
    other[i] = other[i] == 'z' ? 'y' : 'z';
    EXPECT_NE(run_end_of(other), example()) << other;
    EXPECT_EQ(run_end_of(line.substr(0, i)), std::nullopt) << line.substr(0, i);
  }
  const auto with = [&](const std::string& part, const std::string& in_place) {
    std::string other = line;
    const std::size_t at = other.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    return other.replace(at, part.size(), in_place);
  };
  for (const std::string& other :
       {std::string(), std::string("[]"), std::string("3"), with("\"epoch\":3", "\"epoch\":-3"),
        with("\"epoch\":3", "\"epoch\":3.5"), with("\"epoch\":3", "\"epoch\":\"3\""),
        with("\"epoch\":3,", ""), with("\"epoch\":3", "\"epoch\":3,\"more\":1"),
        with("failed", "faild"), with("\"exit_code\":5", "\"exit_code\":99"),
        with("\"00ff\"", "null")}) {
    EXPECT_EQ(run_end_of(other), std::nullopt) << other;
  }
}

}  // namespace
}  // namespace sleight::events
