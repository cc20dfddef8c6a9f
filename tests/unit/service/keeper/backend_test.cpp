// Goal: a daemon and its successor can see, adopt and stop attempts. Neither starts an attempt
// twice.
#include "service/keeper/backend.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "service/keeper/keeper_lock.h"
#include "service/keeper/process_table.h"
#include "tests/unit/service/keeper/job.h"

namespace sleight::keeper {
namespace {

using ::testing::HasSubstr;

class BackendTest : public testing::JobTest {};

TEST_F(BackendTest, AnAttemptFromLaunchToEnd) {
  // Method: call look(), adopt() and stop() before, during and after an attempt. The descriptor of
  // a keeper must signal the end.
  program_is("echo $$ > ready; read -r x < gate");
  ASSERT_EQ(::mkfifo(path("gate").c_str(), 0600), 0);
  EXPECT_EQ(backend().look(folder(), 1).state, Look::State::never_began);
  EXPECT_FALSE(backend().adopt(folder(), 1));
  EXPECT_FALSE(backend().stop(folder(), 1, Stop::now));
  const auto keeper = backend().launch(spec());
  await_file("ready");
  const Look look = backend().look(folder(), 1);
  EXPECT_EQ(look.state, Look::State::running);
  ASSERT_TRUE(look.record);
  EXPECT_EQ(look.record->keeper, keeper.identity());
  const auto adopted = backend().adopt(folder(), 1);
  ASSERT_TRUE(adopted);
  EXPECT_EQ(adopted->identity(), keeper.identity());
  EXPECT_FALSE(keeper.has_gone());
  std::ofstream(path("gate")) << "go\n";
  for (const RunningKeeper* one : {&keeper, &*adopted}) {
    pollfd wait{.fd = one->descriptor(), .events = POLLIN, .revents = 0};
    EXPECT_EQ(::poll(&wait, 1, 20'000), 1);
    EXPECT_TRUE(one->has_gone());
    EXPECT_FALSE(one->stop(Stop::now));
  }
  EXPECT_EQ(backend().look(folder(), 1).state, Look::State::ended);
  EXPECT_FALSE(backend().adopt(folder(), 1));
  EXPECT_FALSE(backend().stop(folder(), 1, Stop::in_order));
  EXPECT_EQ(backend().look(folder(), 2).state, Look::State::never_began);
}

TEST_F(BackendTest, ADoubledLaunchStartsOneProgram) {
  // Method: launch the same attempt from eight threads at once. If this attempt or an earlier
  // attempt is launched later, nothing may happen.
  program_is("echo run >> runs; sleep 0.2");
  std::vector<std::optional<RunningKeeper>> keepers(8);
  std::vector<std::thread> threads;
  for (auto& keeper : keepers)
    threads.emplace_back([&] { keeper.emplace(backend().launch(spec(2))); });
  for (std::thread& thread : threads)
    thread.join();
  for (const auto& keeper : keepers)
    EXPECT_TRUE(testing::comes_true([&] { return keeper->has_gone(); }));
  EXPECT_EQ(backend().look(folder(), 2).state, Look::State::ended);
  for (const std::uint32_t attempt : {2U, 1U}) {
    const auto again = backend().launch(spec(attempt));
    EXPECT_TRUE(testing::comes_true([&] { return again.has_gone(); }));
    EXPECT_THAT(text_in("keeper.err"), HasSubstr("attempt 2 has already begun"));
  }
  EXPECT_EQ(lines_in("runs").size(), 1U);
}

TEST_F(BackendTest, AnAttemptOutlivesItsDaemon) {
  // Method: let a child process launch an attempt. Adopt the attempt in this process. Kill the
  // child and its process group. The program must run until this test ends it.
  program_is(
      "echo $$ > ready; while [ ! -e go ] && [ -e ready ]; do sleep 0.01; done; echo $$ > "
      "survived");
  const pid_t daemon = ::fork();
  if (daemon == 0) {
    ::setsid();
    static_cast<void>(backend().launch(spec()));
    while (true)
      ::pause();
  }
  await_file("ready");
  const auto adopted = backend().adopt(folder(), 1);
  ASSERT_TRUE(adopted);
  ::kill(-daemon, SIGHUP);
  ::kill(-daemon, SIGKILL);
  ::waitpid(daemon, nullptr, 0);
  ::kill(adopted->identity().pid, SIGHUP);
  std::ofstream(path("go")) << "\n";
  EXPECT_EQ(await_end().state, Look::State::ended);
  EXPECT_EQ(text_in("survived"), text_in("ready"));
}

TEST_F(BackendTest, LaunchLeavesNothingInTheDaemon) {
  // Goal: once a launched keeper has ended, the daemon has no zombie and no additional descriptor.
  program_is("exit 0");
  const auto descriptors = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  };
  const auto before = descriptors();
  for (std::uint32_t attempt = 1; attempt <= 5; ++attempt)
    run(spec(attempt));
  EXPECT_EQ(descriptors(), before);
  EXPECT_TRUE(children_of(::getpid()).empty());
}

TEST_F(BackendTest, WhatCantBeLaunchedIsSaid) {
  // Method: try four launches: the keeper doesn't exist; the folder is missing; there are too many
  // ranks; the keeper can't write its record.
  Programs none = backend().programs();
  none.keeper = path("none");
  EXPECT_THROW(LocalBackend(none).launch(spec()), base::Error);
  AttemptSpec bad = spec();
  bad.folder = path("nowhere");
  EXPECT_THROW(backend().launch(bad), base::Error);
  bad = spec();
  bad.ranks = 100'000;
  EXPECT_THROW(backend().launch(bad), base::Error);
  EXPECT_EQ(backend().look(folder(), 1).state, Look::State::never_began);

  std::filesystem::create_directory(path("attempt.json.end"));
  const auto keeper = backend().launch(spec());
  EXPECT_TRUE(testing::comes_true([&] { return keeper.has_gone(); }));
  const Look look = backend().look(folder(), 1);
  EXPECT_EQ(look.state, Look::State::never_began);
  EXPECT_THAT(look.words, HasSubstr("attempt.json.end"));
}

TEST_F(BackendTest, ARecycledNumberIsNeverHit) {
  // Goal: if a process reuses a dead keeper's process id, the process gets no signal, even if the
  // folder seems active. Method: hold the lock, and write a record with a bystander's process id
  // and a wrong start time. Then write a record of an earlier boot.
  const pid_t bystander = ::fork();
  if (bystander == 0) {
    while (true)
      ::pause();
  }
  const pid_t holder = ::fork();
  if (holder == 0) {
    const auto lock = KeeperLock::take(folder());
    while (true)
      ::pause();
  }
  ASSERT_TRUE(testing::comes_true([&] { return KeeperLock::is_held(folder()); }));
  const auto real = identity_of(bystander);
  ASSERT_TRUE(real);
  for (const bool of_other_boot : {false, true}) {
    ProcessIdentity recorded = *real;
    if (of_other_boot) {
      recorded.boot = "another";
    } else {
      recorded.start_ticks -= 1;
    }
    base::PosixFileSystem files;
    RecordFile(files, folder()).begin({.attempt = 1, .keeper = recorded, .command = {"x"}});
    EXPECT_EQ(backend().look(folder(), 1).state, Look::State::running);
    EXPECT_FALSE(backend().adopt(folder(), 1));
    EXPECT_FALSE(backend().stop(folder(), 1, Stop::now));
  }
  // Control: the right process does receive the signal.
  base::PosixFileSystem files;
  RecordFile(files, folder()).begin({.attempt = 1, .keeper = *real, .command = {"x"}});
  EXPECT_TRUE(backend().stop(folder(), 1, Stop::now));
  int status = 0;
  EXPECT_EQ(::waitpid(bystander, &status, 0), bystander);
  EXPECT_TRUE(WIFSIGNALED(status));
  ::kill(holder, SIGKILL);
  ::waitpid(holder, nullptr, 0);
  EXPECT_EQ(backend().look(folder(), 1).state, Look::State::died);
}

TEST_F(BackendTest, AFolderThatCantBeTrustedIsAnError) {
  // Goal: if the record is damaged or belongs to a later attempt, look() throws an error. launch()
  // doesn't overwrite a damaged record.
  program_is("exit 0");
  run(spec(5));
  EXPECT_THROW(backend().look(folder(), 4), base::Error);
  std::ofstream(path("attempt.json")) << "{";
  EXPECT_THROW(backend().look(folder(), 5), base::Error);
  const auto keeper = backend().launch(spec(6));
  EXPECT_TRUE(testing::comes_true([&] { return keeper.has_gone(); }));
  EXPECT_EQ(text_in("attempt.json"), "{");
  EXPECT_THAT(text_in("keeper.err"), HasSubstr("not an attempt record"));
}

}  // namespace
}  // namespace sleight::keeper
