// Goal: only one process at a time holds the lock. Once the holder has ended, the lock is free.
// is_held() doesn't take the lock.
#include "service/keeper/keeper_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <optional>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "tests/unit/service/keeper/job.h"

namespace sleight::keeper {
namespace {

class KeeperLockTest : public testing::JobTest {};

TEST_F(KeeperLockTest, OneHoldsItUntilItHasGone) {
  // Method: take and release the lock in this process. Then let a child take the lock, and kill the
  // child.
  EXPECT_FALSE(KeeperLock::is_held(folder()));
  EXPECT_FALSE(KeeperLock::is_held(path("nowhere")));
  EXPECT_THROW(KeeperLock::take(path("nowhere")), base::Error);
  {
    const auto lock = KeeperLock::take(folder());
    ASSERT_TRUE(lock);
    EXPECT_TRUE(KeeperLock::is_held(folder()));
    EXPECT_FALSE(KeeperLock::take(folder()));
  }
  EXPECT_FALSE(KeeperLock::is_held(folder()));
  const pid_t child = ::fork();
  if (child == 0) {
    const auto lock = KeeperLock::take(folder());
    while (lock)
      ::pause();
    ::_exit(1);
  }
  EXPECT_TRUE(testing::comes_true([&] { return KeeperLock::is_held(folder()); }));
  EXPECT_FALSE(KeeperLock::take(folder()));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_FALSE(KeeperLock::is_held(folder()));
  EXPECT_TRUE(KeeperLock::take(folder()));
}

TEST_F(KeeperLockTest, AnAttemptIsMarkedAsBegunOnce) {
  // Method: mark an attempt from eight threads at once. Only one thread may succeed. Then mark a
  // later attempt; this removes the first mark.
  EXPECT_FALSE(KeeperLock::has_begun(folder(), 1));
  std::atomic<int> marked = 0;
  std::vector<std::thread> several;
  for (int i = 0; i < 8; ++i)
    several.emplace_back([&] { marked += KeeperLock::mark_begun(folder(), 1) ? 1 : 0; });
  for (std::thread& thread : several)
    thread.join();
  EXPECT_EQ(marked, 1);
  EXPECT_TRUE(KeeperLock::has_begun(folder(), 1));
  EXPECT_TRUE(KeeperLock::mark_begun(folder(), 2));
  EXPECT_FALSE(KeeperLock::has_begun(folder(), 1));
  EXPECT_TRUE(KeeperLock::has_begun(folder(), 2));
  EXPECT_THROW(KeeperLock::mark_begun(path("nowhere"), 1), base::Error);
}

TEST_F(KeeperLockTest, ALookIsNeverInTheWay) {
  // Goal: if a keeper starts while a daemon looks at the folder, the keeper gets the lock. Method:
  // another process calls is_held() constantly while this process takes the lock.
  ASSERT_TRUE(KeeperLock::take(folder()));
  const pid_t looker = ::fork();
  if (looker == 0) {
    while (true)
      static_cast<void>(KeeperLock::is_held(folder()));
  }
  for (int i = 0; i < 2000; ++i)
    ASSERT_TRUE(KeeperLock::take(folder())) << i;
  ::kill(looker, SIGKILL);
  ::waitpid(looker, nullptr, 0);
}

}  // namespace
}  // namespace sleight::keeper
