#include "common/store/lease_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <set>
#include <thread>

#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::store {
namespace {

class LeaseFilesOf : public archive::testing::Scratch {
 protected:
  std::string folder() const { return std::filesystem::path(path("x")).parent_path().string(); }
  static std::string text_of(const std::string& token) {
    return LeaseText{.holder = this_process(), .token = token}.to_text();
  }
};

TEST_F(LeaseFilesOf, OneOfManyMakesAFile) {
  // Goal: if several holders try to create the lease file of one generation, only one holder
  // succeeds. The file contains this holder's whole text, and no other file is left. Method: 8
  // threads try to create the same file at once. Repeat this for 20 files.
  constexpr int k_threads = 8;
  for (std::uint64_t generation = 1; generation <= 20; ++generation) {
    std::atomic<int> made = 0;
    std::atomic<int> waiting = k_threads;
    std::vector<std::thread> threads;
    for (int i = 0; i < k_threads; ++i) {
      threads.emplace_back([&] {
        PosixLeaseFiles files(folder(), this_process());
        const std::string text = text_of(make_token());
        --waiting;
        while (waiting > 0)
          std::this_thread::yield();
        const auto own = files.make(generation, text);
        if (!own) return;
        ++made;
        EXPECT_EQ(files.read(generation), text);
      });
    }
    for (std::thread& thread : threads)
      thread.join();
    EXPECT_EQ(made, 1);
  }
  PosixLeaseFiles files(folder(), this_process());
  EXPECT_EQ(files.list().size(), 20U);
  EXPECT_EQ(names().size(), 20U);
}

TEST_F(LeaseFilesOf, WritesItsOwnFileAlone) {
  // Goal: if a holder's lease file was replaced, a write by this holder doesn't change the new
  // file. Method: remove a holder's file, let another holder create the file again, then write as
  // the first holder.
  PosixLeaseFiles files(folder(), this_process());
  const auto first = files.make(3, text_of("first"));
  ASSERT_TRUE(first);
  EXPECT_EQ(files.make(3, text_of("second")), nullptr);
  files.remove(3);
  files.remove(3);
  EXPECT_EQ(files.read(3), std::nullopt);
  const auto second = files.make(3, text_of("second"));
  first->write(text_of("first again"));
  EXPECT_EQ(files.read(3), text_of("second"));
  second->write(text_of("second again"));
  EXPECT_EQ(files.read(3), text_of("second again"));
}

TEST_F(LeaseFilesOf, ListsNumbersAlone) {
  // Goal: list() returns the generations of the lease files and omits all other files. Method:
  // create files whose names resemble the name of a lease file.
  for (const char* name : {"lease.12", "lease.3", "lease.new.12", "lease.", "lease.0", "lease.-1",
                           "lease.4x", "lease", "lock", "lease.99999999999999999999"})
    put_bytes(path(name), "");
  EXPECT_EQ(PosixLeaseFiles(folder(), this_process()).list(), (std::vector<std::uint64_t>{3, 12}));
}

TEST_F(LeaseFilesOf, KnowsTheProcessesOfItsMachine) {
  // Goal: a process counts as running until it is killed, even while it is stopped. Once it is
  // killed, it counts as gone, even before its parent has waited for it. A process number alone
  // doesn't identify a process. If a process is on another machine, its state is unknown. Method:
  // stop and kill a child process.
  PosixLeaseFiles files(folder(), this_process());
  EXPECT_TRUE(files.is_here(this_process()));
  EXPECT_FALSE(files.is_gone(this_process()));

  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t process = ::fork();
  if (process == 0) {
    const std::uint64_t started = this_process().started;
    if (::write(ends[1], &started, sizeof started) != sizeof started) ::_exit(1);
    while (true)
      ::pause();
  }
  LeaseHolder child = this_process();
  child.process = process;
  ASSERT_EQ(::read(ends[0], &child.started, sizeof child.started),
            static_cast<ssize_t>(sizeof child.started));
  ::close(ends[0]);
  ::close(ends[1]);
  EXPECT_TRUE(files.is_here(child));
  LeaseHolder namesake = child;
  namesake.started += 1;
  EXPECT_TRUE(files.is_gone(namesake));
  LeaseHolder elsewhere = child;
  elsewhere.machine += "x";
  ::kill(process, SIGSTOP);
  EXPECT_TRUE(files.is_here(child));

  ::kill(process, SIGKILL);
  siginfo_t info{};
  ::waitid(P_PID, static_cast<id_t>(process), &info, WEXITED | WNOWAIT);
  EXPECT_TRUE(files.is_gone(child));
  EXPECT_FALSE(files.is_here(child));
  ::waitpid(process, nullptr, 0);
  EXPECT_TRUE(files.is_gone(child));
  EXPECT_FALSE(files.is_gone(elsewhere));
  EXPECT_FALSE(files.is_here(elsewhere));
  LeaseHolder unknown = child;
  unknown.machine.clear();
  EXPECT_FALSE(PosixLeaseFiles(folder(), unknown).is_gone(unknown));
}

TEST(LeaseToken, IsNeverTheSame) {
  // Goal: each lease token is unique. Method: compare a thousand tokens.
  std::set<std::string> tokens;
  for (int i = 0; i < 1000; ++i)
    tokens.insert(make_token());
  EXPECT_EQ(tokens.size(), 1000U);
}

}  // namespace
}  // namespace sleight::store
