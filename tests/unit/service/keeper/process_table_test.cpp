// Goal: children_of() and identity_of() agree with the kernel.
#include "service/keeper/process_table.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <optional>
#include <thread>
#include <vector>

namespace sleight::keeper {
namespace {

TEST(ProcessTable, ChildrenAreFoundInBothWays) {
  // Method: start children from two threads. Compare children_of() with a search of all processes.
  // Then kill the children.
  const auto wait_for_ever = [] {
    const pid_t child = ::fork();
    if (child == 0) {
      while (true)
        ::pause();
    }
    return child;
  };
  std::vector<pid_t> made{wait_for_ever(), wait_for_ever()};
  std::thread([&] { made.push_back(wait_for_ever()); }).join();
  std::sort(made.begin(), made.end());
  EXPECT_EQ(children_of(::getpid()), made);
  EXPECT_EQ(children_by_search(::getpid()), made);
  EXPECT_TRUE(has_living_child(::getpid()));
  for (const pid_t child : made) {
    ::kill(child, SIGKILL);
    siginfo_t info{};
    ::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOWAIT);
  }
  // The children are zombies now.
  EXPECT_EQ(children_of(::getpid()), made);
  EXPECT_FALSE(has_living_child(::getpid()));
  for (const pid_t child : made)
    ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(children_of(::getpid()).empty());
  EXPECT_TRUE(children_of(made[0]).empty());
}

TEST(ProcessTable, AnIdentityIsAProcessOfItsOwn) {
  // Goal: two processes that started one after the other have different identities. Once a process
  // has ended, it has no identity.
  const auto self = identity_of(::getpid());
  ASSERT_TRUE(self);
  EXPECT_EQ(self, identity_of(::getpid()));
  EXPECT_FALSE(self->boot.empty());
  std::optional<ProcessIdentity> other;
  while (!other || other->start_ticks == self->start_ticks) {
    const pid_t child = ::fork();
    if (child == 0) {
      while (true)
        ::pause();
    }
    other = identity_of(child);
    ASSERT_TRUE(other);
    EXPECT_GE(other->start_ticks, self->start_ticks);
    EXPECT_EQ(other->boot, self->boot);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_EQ(identity_of(child), std::nullopt);
  }
}

}  // namespace
}  // namespace sleight::keeper
