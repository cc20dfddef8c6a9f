// Goal: the log stores output in order and never exceeds its size limit. If output is lost, the log
// says so.
#include "service/keeper/bounded_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/unit/service/keeper/job.h"

namespace sleight::keeper {
namespace {

class BoundedLogTest : public testing::JobTest {};

TEST_F(BoundedLogTest, KeepsTheNewestUnderItsBound) {
  // Method: append pieces of many sizes. One piece exceeds the limit. The two files together must
  // contain the last part of the output.
  std::string all;
  BoundedLog log(folder(), 2000);
  for (const std::size_t size : {1UL, 300UL, 699UL, 1UL, 5000UL, 10UL, 990UL}) {
    std::string piece;
    while (piece.size() < size)
      piece += std::to_string(all.size() + piece.size()) + "\n";
    log.append(piece);
    all += piece;
    const std::string kept = text_in("log.old") + text_in("log");
    EXPECT_LE(text_in("log.old").size(), 1000U);
    EXPECT_LE(text_in("log").size(), 1000U);
    EXPECT_TRUE(all.ends_with(kept));
    EXPECT_GE(kept.size(), std::min<std::size_t>(all.size(), 1000));
  }
}

TEST_F(BoundedLogTest, GoesOnWithMarkedLines) {
  // Method: a killed keeper left a log whose last line is incomplete. Continue the log.
  {
    BoundedLog log(folder());
    log.mark("attempt 1: a\nb");
    log.append("one\ntw");
  }
  BoundedLog log(folder());
  log.mark("attempt 2");
  log.append("three\n");
  log.mark("ended");
  EXPECT_EQ(text_in("log"), "=== attempt 1: a b\none\ntw\n=== attempt 2\nthree\n=== ended\n");
}

TEST_F(BoundedLogTest, SaysWhatWasLost) {
  // Method: put a folder in the log's place, so that writing fails. Then remove the folder.
  std::filesystem::create_directory(path("log"));
  BoundedLog log(folder());
  log.append("lost\n");
  log.append("this too\n");
  std::filesystem::remove(path("log"));
  log.append("kept\n");
  EXPECT_THAT(text_in("log"), ::testing::MatchesRegex("=== 14 bytes .* lost .*\nkept\n"));
}

TEST_F(BoundedLogTest, TheBoundHoldsWhereItCantTurnOver) {
  // Method: put a folder that isn't empty in the old log's place, so that no file can replace it.
  std::filesystem::create_directories(path("log.old/x"));
  BoundedLog log(folder(), 200);
  for (int i = 0; i < 100; ++i)
    log.append("0123456789\n");
  EXPECT_LE(text_in("log").size(), 100U);
  EXPECT_TRUE(text_in("log").ends_with("0123456789\n"));
}

TEST(LastLines, AreTheLastOnes) {
  // Method: append lines in pieces. One line is too long, and the last line is incomplete.
  LastLines last(3);
  EXPECT_TRUE(last.lines().empty());
  last.append("one\ntw");
  EXPECT_EQ(last.lines(), (std::vector<std::string>{"one", "tw"}));
  last.append("o\nthree\n");
  std::string too_long(1000, 'x');
  too_long += '\n';
  last.append(too_long);
  EXPECT_EQ(last.lines(), (std::vector<std::string>{
                              "two", "three", std::string(LastLines::k_line_bytes_max, 'x')}));
  last.append("end");
  EXPECT_EQ(last.lines().size(), 3U);
  EXPECT_EQ(last.lines().back(), "end");
}

}  // namespace
}  // namespace sleight::keeper
