#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <csignal>
#include <functional>
#include <optional>

#include "common/base/error.h"
#include "common/store/run_store.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::store {
namespace {

using ::testing::HasSubstr;

/// Tries to take the lock. Returns the error message, or nothing if the lock was free.
std::optional<std::string> conflict_of(const std::string& folder) {
  try {
    const RunLock lock(folder);
    return std::nullopt;
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::conflict);
    return error.what();
  }
}

class Holder {
 public:
  explicit Holder(const std::string& folder) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    process_ = ::fork();
    if (process_ == 0) {
      const RunLock lock(folder);
      if (::write(ends[1], "x", 1) != 1) ::_exit(1);
      while (true)
        ::pause();
    }
    char taken = 0;
    EXPECT_EQ(::read(ends[0], &taken, 1), 1);
    ::close(ends[0]);
    ::close(ends[1]);
  }
  ~Holder() { kill(); }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;

  void kill() {
    if (process_ == 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    process_ = 0;
  }
  pid_t process() const { return process_; }

 private:
  pid_t process_ = 0;
};

class RunLockOf : public testing::RunFolder {};

TEST_F(RunLockOf, OneProcessAtATime) {
  // Goal: if one process holds a run's lock, a second process gets an error with the first
  // process's number. Once a process is killed, it holds no lock. Method: let a child take the
  // lock, and kill the child. Do this ten times.
  for (int i = 0; i < 10; ++i) {
    Holder holder(folder());
    const auto conflict = conflict_of(folder());
    ASSERT_TRUE(conflict.has_value());
    EXPECT_THAT(*conflict, HasSubstr(folder()));
    EXPECT_THAT(*conflict, HasSubstr(fmt::format("({})", holder.process())));
    holder.kill();
    EXPECT_EQ(conflict_of(folder()), std::nullopt);
  }
}

TEST_F(RunLockOf, OneObjectAtATime) {
  // Goal: two runs in one process can't share a folder, and a refused attempt doesn't release the
  // lock. Method: try twice to take a lock that is held. Take it after its release.
  {
    const RunLock first(folder());
    EXPECT_TRUE(conflict_of(folder()).has_value());
    EXPECT_TRUE(conflict_of(folder()).has_value());
  }
  EXPECT_EQ(conflict_of(folder()), std::nullopt);
}

TEST_F(RunLockOf, MakesTheFolder) {
  // Goal: taking the lock creates the run's folder, or the error names its path. Method: use a new
  // folder, a folder whose parent is missing, and a file.
  EXPECT_EQ(conflict_of(path("new")), std::nullopt);
  EXPECT_EQ(bytes_of(path("new/lock")), fmt::format("{}\n", ::getpid()));
  put_bytes(path("file"), "x");
  for (const std::string& bad : {path("missing/run"), path("file")}) {
    try {
      const RunLock lock(bad);
      ADD_FAILURE() << bad;
    } catch (const base::Error& error) {
      EXPECT_EQ(error.exit_code(), base::ExitCode::environment);
      EXPECT_THAT(error.what(), HasSubstr(bad));
    }
  }
}

TEST_F(RunLockOf, StrangeContentIsNoObstacle) {
  // Goal: taking the lock replaces any old content of the lock file.
  put_bytes(path("run/lock"), std::string(1000, 'z'));
  const RunLock lock(folder());
  EXPECT_EQ(bytes_of(path("run/lock")), fmt::format("{}\n", ::getpid()));
}

}  // namespace
}  // namespace sleight::store
