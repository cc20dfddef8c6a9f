// Goal: a reader that follows a log gets each byte once, unless the bounded log has dropped it.
// Method: write random pieces to the keeper's bounded log. Compare the pieces with the bytes that a
// reader gets.
#include "service/daemon/logs.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "common/random/stream.h"
#include "service/keeper/bounded_log.h"

namespace sleight::daemon {
namespace {

class LogsTest : public ::testing::Test {
 protected:
  LogsTest() {
    folder_ = std::filesystem::temp_directory_path() / ("logs-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~LogsTest() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(LogsTest, AFollowerGetsAllThatIsPrinted) {
  keeper::BoundedLog log(folder_, 4000);
  Logs logs;
  random::Stream stream({.seed = 3, .purpose = random::Purpose::scene}, 0);
  std::string printed;
  std::string followed;
  std::uint64_t next = 0;
  for (int step = 0; step < 500; ++step) {
    std::string piece(stream.bits() % 300, static_cast<char>('a' + step % 26));
    piece += "\n";
    log.append(piece);
    printed += piece;
    const rpc::LogPiece got = logs.read(folder_, {.from = next, .bytes_max = 1U << 20U});
    ASSERT_EQ(got.first, next) << "nothing is lost to a follower that reads often";
    followed += got.text;
    next = got.first + got.text.size();
    ASSERT_EQ(got.end, next);
  }
  EXPECT_EQ(followed, printed);
}

TEST_F(LogsTest, LastLinesAndWhatIsLost) {
  keeper::BoundedLog log(folder_, 400);
  for (int line = 0; line < 100; ++line)
    log.append("line " + std::to_string(line) + "\n");
  Logs logs;
  EXPECT_EQ(logs.read(folder_, {.lines = 2}).text, "line 98\nline 99\n");
  const rpc::LogPiece all = logs.read(folder_, {.from = 0});
  EXPECT_LT(all.text.size(), 401U);
  EXPECT_TRUE(all.text.ends_with("line 99\n"));
  EXPECT_EQ(logs.read(folder_, {.from = 1'000'000}).text, "");
  EXPECT_EQ(logs.read(folder_ / "none", {}).text, "");
}

}  // namespace
}  // namespace sleight::daemon
