// Goal: an attempt's end is recorded correctly, and no process of its program is left. Method: let
// real keepers run shell scripts that end, hang, fork and print in many ways.
#include "service/keeper/keep.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "service/keeper/process_table.h"
#include "tests/unit/service/keeper/job.h"

namespace sleight::keeper {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class KeepTest : public testing::JobTest {
 protected:
  static std::string told(events::End end, int code) {
    const std::string line = events::to_line(
        {.epoch = 1, .end = end, .exit_code = static_cast<base::ExitCode>(code), .scans = 7});
    return "echo '" + line.substr(0, line.size() - 1) + "' > end.pipe";
  }
  /// Returns true if the process whose id is in the file has ended.
  bool has_gone(const std::string& name) const {
    const pid_t pid = std::stoi(text_in(name));
    return ::kill(pid, 0) != 0 && errno == ESRCH;
  }
};

TEST_F(KeepTest, HowItEnded) {
  // Method: run three programs. One program exits with a code, one is killed by a signal, and one
  // is missing.
  program_is("echo out; echo err >&2; printf 'no end'; exit 7");
  AttemptEnd end = run(spec(1));
  EXPECT_EQ(end.exit_code, 7);
  EXPECT_EQ(end.signal, std::nullopt);
  EXPECT_EQ(end.run_end, std::nullopt);
  EXPECT_EQ(end.killed_for, KilledFor::nothing);
  EXPECT_THAT(end.log_tail, ElementsAre("out", "err", "no end"));
  EXPECT_GT(end.wall_s, 0);
  EXPECT_GT(end.processor_s, 0);
  EXPECT_GT(end.memory_bytes_max, 100'000U);

  program_is("kill -SEGV $$");
  end = run(spec(2));
  EXPECT_EQ(end.signal, SIGSEGV);
  EXPECT_EQ(end.exit_code, std::nullopt);

  std::filesystem::remove(path("program"));
  end = run(spec(3));
  EXPECT_THAT(end.not_started, HasSubstr("No such file"));
  EXPECT_EQ(end.exit_code, std::nullopt);
  EXPECT_THAT(text_in("log"), HasSubstr("=== attempt 1: ended with exit code 7\n"));
  EXPECT_THAT(text_in("log"), HasSubstr("no end\n=== attempt 1: ended"));
  EXPECT_THAT(text_in("log"), HasSubstr("=== attempt 2: ended by signal 11\n"));
  EXPECT_THAT(text_in("log"), HasSubstr("No such file"));
}

TEST_F(KeepTest, WhatTheProgramTold) {
  // Goal: the record has the first end that the program reports. Method: the program opens the pipe
  // late, then writes garbage and two ends.
  program_is("sleep 0.1; echo garbage > end.pipe; " + told(events::End::no_draws, 0) + "; " +
             told(events::End::finished, 0));
  const AttemptEnd end = run();
  ASSERT_TRUE(end.run_end);
  EXPECT_EQ(end.run_end->end, events::End::no_draws);
  EXPECT_EQ(end.run_end->scans, 7U);
  EXPECT_EQ(end.exit_code, 0);
}

TEST_F(KeepTest, NothingOfItIsLeft) {
  // Method: let the program end while three of its processes still run. One process ignores
  // signals, one has forked twice into its own session, and one forks constantly.
  program_is(
      "(trap '' TERM HUP INT; echo $$ > /dev/null; while :; do sleep 1; done) & echo $! > child\n"
      "setsid sh -c '(sh -c \"echo \\$\\$ > daemon; sleep 1000\" &)'\n"
      "sh -c 'echo $$ > forker; while :; do sleep 1000 & sleep 0.002; done' &\n"
      "while [ ! -s daemon ] || [ ! -s forker ]; do sleep 0.01; done; exit 0");
  EXPECT_EQ(run().exit_code, 0);
  for (const char* name : {"child", "daemon", "forker"})
    EXPECT_TRUE(has_gone(name)) << name;
}

TEST_F(KeepTest, StoppedInOrder) {
  // Method: stop a program that handles SIGUSR1.
  program_is(
      "trap 'touch told; exit 130' USR1\n"
      "echo $$ > ready; while :; do sleep 0.01; done");
  const auto keeper = backend().launch(spec());
  await_file("ready");
  EXPECT_TRUE(backend().stop(folder(), 1, Stop::in_order));
  const Look look = await_end();
  ASSERT_EQ(look.state, Look::State::ended);
  EXPECT_EQ(look.record->end->exit_code, 130);
  EXPECT_EQ(look.record->end->stop_asked, Stop::in_order);
  EXPECT_EQ(look.record->end->killed_for, KilledFor::nothing);
  EXPECT_TRUE(std::filesystem::exists(path("told")));
}

TEST_F(KeepTest, StoppedNow) {
  // Method: let a program and its child ignore SIGTERM and SIGUSR1. Request a clean stop, then an
  // immediate stop.
  program_is(
      "trap '' TERM USR1; sh -c 'echo $$ > child; while :; do sleep 1; done' &\n"
      "while [ ! -s child ]; do sleep 0.01; done; echo $$ > ready; wait; sleep 1000");
  const auto keeper = backend().launch(spec());
  await_file("ready");
  EXPECT_TRUE(keeper.stop(Stop::in_order));
  EXPECT_FALSE(keeper.has_gone());
  EXPECT_TRUE(keeper.stop(Stop::now));
  const Look look = await_end();
  ASSERT_EQ(look.state, Look::State::ended);
  EXPECT_EQ(look.record->end->signal, SIGKILL);
  EXPECT_EQ(look.record->end->stop_asked, Stop::now);
  EXPECT_EQ(look.record->end->killed_for, KilledFor::asked);
  EXPECT_TRUE(has_gone("child"));
}

TEST_F(KeepTest, ASignalThatComesAtOnceIsNotLost) {
  // Goal: if a stop comes right after the launch, the attempt ends, even if the keeper can't handle
  // signals yet.
  program_is("sleep 1000");
  for (std::uint32_t attempt = 1; attempt <= 10; ++attempt) {
    const auto keeper = backend().launch(spec(attempt));
    EXPECT_TRUE(keeper.stop(attempt % 2 == 0 ? Stop::now : Stop::in_order));
    ASSERT_TRUE(testing::comes_true([&] { return keeper.has_gone(); }));
    const Look look = await_end(attempt);
    ASSERT_EQ(look.state, Look::State::ended);
    EXPECT_TRUE(look.record->end->stop_asked);
  }
}

TEST_F(KeepTest, AProgramThatLingersIsKilled) {
  // Method: the program reports its end but doesn't exit.
  program_is(told(events::End::finished, 0) + "; sleep 1000");
  AttemptSpec graced = spec();
  graced.grace_s = 0.2;
  const AttemptEnd end = run(graced);
  EXPECT_EQ(end.killed_for, KilledFor::lingering);
  EXPECT_EQ(end.signal, SIGKILL);
  ASSERT_TRUE(end.run_end);
  EXPECT_EQ(end.run_end->end, events::End::finished);
  EXPECT_GE(end.wall_s, 0.2);
}

TEST_F(KeepTest, AnMpirunWithoutRanksIsKilled) {
  // Method: use a script in place of mpirun. The script hangs after its rank has ended, as Debian
  // 12's mpirun sometimes does. The keeper must not kill the script before the first rank has
  // started.
  program_is("sleep 0.5 & wait; while :; do read x < /dev/zero; done");
  AttemptSpec ranks = spec();
  ranks.ranks = 1;
  ranks.grace_s = 0.3;
  const AttemptEnd end = run(ranks);
  EXPECT_EQ(end.killed_for, KilledFor::without_ranks);
  EXPECT_GE(end.wall_s, 0.3);
  EXPECT_FALSE(std::filesystem::exists(path("mpi")));
}

TEST_F(KeepTest, AStopInOrderWaitsForTheFirstRank) {
  // Goal: if a stop comes before the first rank starts, the stop isn't lost, although mpirun passes
  // signals only to existing ranks. Method: use a script in place of mpirun. The script starts its
  // rank late.
  program_is(
      "echo $$ > ready; read -r x < gate\n"
      "trap 'touch taken; kill $!; exit 130' USR1; sleep 1000 & while :; do wait; done");
  ASSERT_EQ(std::system(fmt::format("mkfifo {}", path("gate")).c_str()), 0);
  AttemptSpec ranks = spec();
  ranks.ranks = 1;
  const auto keeper = backend().launch(ranks);
  await_file("ready");
  EXPECT_TRUE(keeper.stop(Stop::in_order));
  ::poll(nullptr, 0, 100);
  EXPECT_FALSE(keeper.has_gone());
  std::ofstream(path("gate")) << "go\n";
  const Look look = await_end();
  ASSERT_EQ(look.state, Look::State::ended);
  EXPECT_EQ(look.record->end->exit_code, 130);
  EXPECT_TRUE(std::filesystem::exists(path("taken")));
}

TEST_F(KeepTest, TheProgramGetsNothingThatIsNotItsOwn) {
  // Goal: the program inherits nothing from the keeper or the daemon: no descriptors, terminal,
  // blocked or ignored signals, limits or variables. Method: open files, ignore signals and set
  // variables in the daemon. Let the script write down what it inherits.
  program_is(
      "ls /proc/self/fd > fds; readlink /proc/self/fd/0 > stdin; env > env; pwd > pwd\n"
      "grep -E 'SigBlk|SigIgn' /proc/self/status > signals; ulimit -c > core\n"
      "ps -o sid= -p $$ | tr -d ' ' > session; echo $$ > self");
  const std::ofstream open_in_daemon(path("other"));
  ::setenv("LD_LIBRARY_PATH", "/nowhere", 1);
  ::setenv("OMPI_MCA_btl", "tcp", 1);
  const auto ignored = std::signal(SIGUSR1, SIG_IGN);
  EXPECT_EQ(run().exit_code, 0);
  std::signal(SIGUSR1, ignored);
  ::unsetenv("LD_LIBRARY_PATH");
  ::unsetenv("OMPI_MCA_btl");
  // Descriptor 3 is the folder that `ls` reads.
  EXPECT_THAT(lines_in("fds"), ElementsAre("0", "1", "2", "3"));
  EXPECT_EQ(text_in("stdin"), "/dev/null\n");
  EXPECT_EQ(text_in("pwd"), folder() + "\n");
  EXPECT_THAT(text_in("env"), ::testing::Not(HasSubstr("LD_LIBRARY")));
  EXPECT_THAT(text_in("env"), ::testing::Not(HasSubstr("OMPI_MCA")));
  EXPECT_THAT(lines_in("signals"),
              ElementsAre("SigBlk:\t0000000000000000", "SigIgn:\t0000000000000000"));
  EXPECT_EQ(text_in("core"), "0\n");
  EXPECT_EQ(text_in("session"), text_in("self"));
}

TEST_F(KeepTest, WhatADeadAttemptLeftIsCleared) {
  // Method: before an attempt, create Open MPI's files. Put a regular file in the pipe's place.
  std::filesystem::create_directories(path("mpi/ompi.vm.0/pid.1"));
  std::ofstream(path("mpi/vader_segment.vm.0")) << "x";
  std::ofstream(path("end.pipe")) << "no pipe";
  program_is("ls > seen; exit 0");
  EXPECT_EQ(run().run_end, std::nullopt);
  EXPECT_THAT(lines_in("seen"), ::testing::Not(::testing::Contains("mpi")));
  EXPECT_TRUE(std::filesystem::is_fifo(path("end.pipe")));
}

TEST_F(KeepTest, InABatchSystemsJobSigtermEndsInOrder) {
  // Goal: if a batch system sends SIGTERM some time before it kills all processes, the program can
  // use this time to stop. Method: send SIGTERM to the program and the keeper, as scancel does. The
  // program must get SIGUSR1 once and have the batch job's variables.
  program_is(
      "trap 'echo term >> told' TERM; trap 'echo usr1 >> told; exit 130' USR1; echo $SLURM_JOB_ID "
      "> "
      "number; echo $$ > pid; while true; do sleep 0.02; done");
  AttemptSpec in_batch = spec();
  in_batch.in_batch = true;
  ::setenv("SLURM_JOB_ID", "812", 1);
  // A batch system starts the keeper's command in its own environment.
  const RunningKeeper keeper = backend().launch_command(
      folder(), {"/usr/bin/env", "SLURM_JOB_ID=812", "sh", "-c", fmt::format("exec {}", [&] {
                   std::string words;
                   for (const std::string& word : keeper_command_of(in_batch, backend().programs()))
                     words += "'" + word + "' ";
                   return words;
                 }())});
  ::unsetenv("SLURM_JOB_ID");
  await_file("pid");
  ::kill(std::stoi(text_in("pid")), SIGTERM);
  EXPECT_TRUE(keeper.stop(Stop::now));
  const Look look = await_end();
  ASSERT_EQ(look.state, Look::State::ended);
  EXPECT_EQ(look.record->end->stop_asked, Stop::in_order);
  EXPECT_EQ(look.record->end->exit_code, 130);
  EXPECT_EQ(look.record->end->killed_for, KilledFor::nothing);
  EXPECT_EQ(text_in("told"), "usr1\n");
  EXPECT_EQ(text_in("number"), "812\n");
}

TEST_F(KeepTest, InABatchSystemsJobOnANetworkDiskAnAttemptBeginsOnce) {
  // Goal: on a disk without locks, records may appear late. There, the file `begun.N` prevents a
  // second start of attempt N. Method: delete the record as if it weren't visible yet. Launch the
  // same attempt again.
  ::setenv("SLEIGHT_NETWORK_DISK", "1", 1);
  program_is("echo started >> starts");
  AttemptSpec in_batch = spec();
  in_batch.in_batch = true;
  run(in_batch);
  EXPECT_TRUE(std::filesystem::exists(path("begun.1")));
  EXPECT_FALSE(std::filesystem::exists(path("keeper.lock")));
  std::filesystem::remove(path("attempt.json"));
  const RunningKeeper again = backend().launch(in_batch);
  EXPECT_TRUE(testing::comes_true([&] { return again.has_gone(); }));
  EXPECT_EQ(text_in("starts"), "started\n");
  EXPECT_THAT(text_in(k_keeper_words_name), HasSubstr("attempt 1 has already begun"));
  in_batch.attempt = 2;
  run(in_batch);
  EXPECT_EQ(text_in("starts"), "started\nstarted\n");
  EXPECT_FALSE(std::filesystem::exists(path("begun.1")));
  ::unsetenv("SLEIGHT_NETWORK_DISK");
}

TEST_F(KeepTest, StartedTwiceByABatchSystemTheSecondKeeperWaitsForTheFirst) {
  // Goal: if an attempt has two keepers, the second doesn't end while the first lives, and passes a
  // stop on to the first. Method: start two keepers of an attempt and stop the second. Use a local
  // disk, then a network disk.
  for (const char* network : {"0", "1"}) {
    ::setenv("SLEIGHT_NETWORK_DISK", network, 1);
    program_is("echo started >> starts; trap 'exit 130' USR1; while true; do sleep 0.02; done");
    AttemptSpec in_batch = spec(network[0] == '0' ? 1 : 2);
    in_batch.in_batch = true;
    const RunningKeeper first = backend().launch(in_batch);
    EXPECT_TRUE(testing::comes_true([&] { return !lines_in("starts").empty(); }));
    const RunningKeeper second = backend().launch(in_batch);
    EXPECT_TRUE(testing::comes_true([&] {
      return text_in(k_keeper_words_name).find("has already begun") != std::string::npos;
    }));
    EXPECT_FALSE(second.has_gone());
    EXPECT_FALSE(first.has_gone());
    EXPECT_TRUE(second.stop(Stop::in_order));
    EXPECT_TRUE(testing::comes_true([&] { return first.has_gone() && second.has_gone(); }));
    EXPECT_EQ(lines_in("starts").size(), 1U);
    EXPECT_EQ(read_record(folder())->end->exit_code, 130);
    std::filesystem::remove(path("starts"));
  }
  ::unsetenv("SLEIGHT_NETWORK_DISK");
}

TEST_F(KeepTest, AKeeperThatWasGivenUpWritesNothingOverALaterRecord) {
  // Method: write a later attempt's record while the keeper of an earlier attempt runs.
  ::setenv("SLEIGHT_NETWORK_DISK", "1", 1);
  program_is("touch begun; while [ ! -e go ]; do sleep 0.02; done");
  AttemptSpec in_batch = spec();
  in_batch.in_batch = true;
  const RunningKeeper keeper = backend().launch(in_batch);
  EXPECT_TRUE(testing::comes_true([&] { return std::filesystem::exists(path("begun")); }));
  AttemptRecord later = *read_record(folder());
  later.attempt = 2;
  std::ofstream(path("attempt.json")) << to_text(later);
  std::ofstream(path("go")).flush();
  EXPECT_TRUE(testing::comes_true([&] { return keeper.has_gone(); }));
  EXPECT_EQ(read_record(folder()), later);
  EXPECT_THAT(text_in(k_keeper_words_name), HasSubstr("considered lost"));
  ::unsetenv("SLEIGHT_NETWORK_DISK");
}

}  // namespace
}  // namespace sleight::keeper
