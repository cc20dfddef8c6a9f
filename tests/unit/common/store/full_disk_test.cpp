// Goal: if the disk fills up or fails, a run keeps its committed scans and can be resumed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>

#include "common/base/error.h"
#include "common/store/run_store.h"
#include "tests/support/property.h"
#include "tests/unit/common/store/examples.h"
#include "tests/unit/common/store/faulty_disk.h"

namespace sleight::store {
namespace {

using testing::example_identity;
using testing::expect_stored;
using ::testing::HasSubstr;
using testing::result_of;

class FullDisk : public testing::RunFolder {};

/// Returns the number of stored scans of chain 0. The chain must have no gap and end with the right
/// state.
std::uint64_t stored_scans(const std::string& folder) {
  RunStore store(folder, example_identity(1));
  const std::vector<ReplicaProgress> progress = store.progress();
  const std::uint64_t scans = progress.empty() ? 0 : progress.at(0).next_scan;
  expect_stored(folder, store, 0, scans);
  return scans;
}

TEST_F(FullDisk, AnyCallMayFail) {
  // Goal: whichever write or sync fails, the store reports a clear error, committed scans stay
  // whole, and the run can be resumed. Method: let a session's first k disk calls succeed and all
  // later calls fail. Then reopen the store. Increase k until a session succeeds. Simulate a full
  // disk for every k, and a write error for every third k. The fast tier tests fewer values of k.
  testing::FaultyDisk disk;
  struct Fault {
    int code;
    std::uint64_t step;
    std::string advice;
  };
  for (const auto& [code, step, advice] :
       {Fault{SQLITE_FULL, property::of_tier(4, 1), "free disk space"},
        Fault{SQLITE_IOERR_WRITE, property::of_tier(10, 3), "check the disk"}}) {
    bool got_through = false;
    std::uint64_t call = 0;
    for (; !got_through; call += step) {
      SCOPED_TRACE(fmt::format("code {}, call {}", code, call));
      const std::string folder = path(fmt::format("run-{}-{}", code, call));
      std::filesystem::create_directory(folder);
      { RunStore(folder, example_identity(1)).put(result_of(0, 0, 3)); }
      disk.fail_after(call, code);
      std::uint64_t committed = 3;
      try {
        RunStore store(folder, example_identity(1));
        for (std::uint64_t scan = 3; scan < 40; scan += 19) {
          store.put(result_of(0, scan, 19));
          store.flush();
          committed = 3 + store.committed();
        }
        got_through = disk.failures() == 0;
      } catch (const base::Error& error) {
        EXPECT_EQ(error.exit_code(), base::ExitCode::environment);
        EXPECT_THAT(error.what(), AllOf(HasSubstr(folder), HasSubstr(advice)));
      }
      disk.repair();
      const std::uint64_t found = stored_scans(folder);
      EXPECT_GE(found, committed);
      EXPECT_EQ((found - 3) % 19, 0U);
      if (HasFailure()) return;
      {
        RunStore store(folder, example_identity(1));
        store.put(result_of(0, found, 5));
        store.flush();
        expect_stored(folder, store, 0, found + 5);
      }
    }
    EXPECT_GT(call, 10U);
  }
}

TEST_F(FullDisk, MiddleOfALargeGroup) {
  // Goal: if one write of a group of results fails, the store keeps no result of the group, even if
  // the disk works again at once. Method: store a result that is larger than SQLite's cache, so
  // SQLite writes pages before the commit. Let a different disk call fail in each run.
  testing::FaultyDisk disk;
  const std::uint64_t step = property::of_tier(120, 40);
  std::uint64_t failed = 0;
  for (std::uint64_t call = 0; call < 600; call += step) {
    SCOPED_TRACE(fmt::format("call {}", call));
    const std::string folder = path(fmt::format("run-{}", call));
    std::filesystem::create_directory(folder);
    {
      RunStore store(folder, example_identity(1));
      store.put(result_of(0, 0, 3));
      store.flush();
      disk.fail_after(call, SQLITE_FULL, 1);
      store.put(result_of(0, 3, 20'000));
      try {
        store.flush();
      } catch (const base::Error&) {
        ++failed;
        EXPECT_EQ(store.committed(), 3U);
      }
    }
    disk.repair();
    const std::uint64_t found = stored_scans(folder);
    EXPECT_TRUE(found == 3 || found == 20'003) << found;
    if (HasFailure()) return;
  }
  EXPECT_GT(failed, 200 / step);
}

TEST_F(FullDisk, FailureStopsTheSession) {
  // Goal: once a write has failed, the session writes nothing more, even if there is space again.
  // Later results would leave a gap. Method: let a write fail and repair the disk. Then put more
  // results.
  testing::FaultyDisk disk;
  {
    RunStore store(folder(), example_identity(1));
    store.put(result_of(0, 0, 3));
    store.flush();
    disk.fail_after(0, SQLITE_FULL);
    store.put(result_of(0, 3, 3));
    EXPECT_THROW(store.flush(), base::Error);
    disk.repair();
    EXPECT_THROW(store.put(result_of(0, 6, 3)), base::Error);
    EXPECT_THROW(store.flush(), base::Error);
    EXPECT_EQ(store.committed(), 3U);
  }
  EXPECT_EQ(stored_scans(folder()), 3U);
}

TEST_F(FullDisk, FileSizeLimit) {
  // Goal: committed scans stay whole if the operating system refuses a write. Method: limit the
  // size of a child process's files. Let the child store results until a write fails. Compare the
  // stored scans with the last number that the child's committed() returned.
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit limit{.rlim_cur = 600'000, .rlim_max = 600'000};
    std::signal(SIGXFSZ, SIG_IGN);
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(2);
    try {
      RunStore store(folder(), example_identity(1));
      for (std::uint64_t scan = 0; scan < 1'000'000; scan += 50) {
        store.put(result_of(0, scan, 50));
        store.flush();
        const std::uint64_t committed = store.committed();
        if (::write(ends[1], &committed, sizeof committed) != sizeof committed) ::_exit(3);
      }
    } catch (const base::Error& error) {
      ::_exit(std::string(error.what()).find("run the same command again") == std::string::npos);
    }
    ::_exit(4);
  }
  ::close(ends[1]);
  std::uint64_t committed = 0;
  while (::read(ends[0], &committed, sizeof committed) == sizeof committed) {
  }
  ::close(ends[0]);
  int status = -1;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_GT(committed, 100U);
  EXPECT_EQ(stored_scans(folder()), committed);
}

}  // namespace
}  // namespace sleight::store
