// Goal: the Slurm backend runs the right commands and interprets their output, even if the output
// is lost or unusual. Method: use scripts in place of sbatch, squeue and scancel. The scripts log
// their arguments and print prepared files. test_slurm_backend.py uses a real Slurm.
#include "service/backend/slurm_backend.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace sleight::backend {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class HandClock final : public base::Clock {
 public:
  double now_s() const override { return now; }
  double now = 0;
};

class SlurmBackendTest : public ::testing::Test {
 protected:
  SlurmBackendTest() {
    std::string pattern = "/tmp/sleight-slurm-XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
    program("squeue", "cat queue");
    program("sbatch", "echo 812");
    program("scancel", "true");
    write("queue", "");
  }
  ~SlurmBackendTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(path(name)) << text;
  }
  std::string text(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(path(name)).rdbuf();
    return text.str();
  }
  /// Creates a program that writes each of its arguments to a line of a log, then runs the script.
  void program(const std::string& name, const std::string& script) {
    write(name, fmt::format("#!/bin/sh\ncd {0}\nprintf '%s\\n' \"$@\" >> {1}.asked\necho >> "
                            "{1}.calls\n{2}\n",
                            folder_, name, script));
    std::filesystem::permissions(path(name), std::filesystem::perms::owner_all);
  }
  std::size_t calls(const std::string& name) const { return text(name + ".calls").size(); }

  SlurmBackend backend(Options defaults = {}) {
    return {{.script = "/opt/direct.sbatch",
             .defaults = std::move(defaults),
             .tool_s_max = 5,
             .sbatch = path("sbatch"),
             .squeue = path("squeue"),
             .scancel = path("scancel")},
            clock_};
  }
  Order order(std::uint64_t job = 17) const {
    return {.name = {.daemon = "abcdefgh", .job = job, .epoch = 3},
            .folder = "/jobs/a 17",
            .command = {"/opt/sleight-keeper", "--folder", "/jobs/a 17"},
            .label = "sleight-17",
            .cores = 4};
  }

  std::string folder_;
  HandClock clock_;
};

TEST_F(SlurmBackendTest, SubmitsAnAttemptOnce) {
  // Method: compare the whole sbatch command. Launch the same attempt again, with the same backend
  // object and with a new backend object. sbatch must run only once.
  auto slurm = backend({{"partition", "long"}});
  Order wanted = order();
  wanted.memory_bytes = 3'000'000'001;
  wanted.options = {{"account", "x y"}, {"more", "--nice=5"}};
  const Seen seen = slurm.launch(wanted);
  EXPECT_EQ(seen.state, State::waiting);
  EXPECT_EQ(seen.id, "812");
  EXPECT_EQ(text("sbatch.asked"),
            "--parsable\n--no-requeue\n--comment=sleight:abcdefgh:17:3\n--job-name=sleight-17\n"
            "--chdir=/jobs/a 17\n--output=/jobs/a 17/keeper.err\n--open-mode=append\n--ntasks=1\n"
            "--cpus-per-task=4\n--nodes=1\n--mem=3001M\n--account=x y\n--partition=long\n--nice=5\n"
            "/opt/direct.sbatch\n--attempt\n/opt/sleight-keeper\n--folder\n/jobs/a 17\n");
  EXPECT_EQ(slurm.launch(wanted).id, "812");
  EXPECT_EQ(slurm.state(wanted.name).id, "812");
  write("queue", "812|RUNNING|None|sleight:abcdefgh:17:3\n");
  EXPECT_EQ(backend().launch(wanted).state, State::running);
  EXPECT_EQ(calls("sbatch"), 1U);
}

TEST_F(SlurmBackendTest, FoldersAreNoPatterns) {
  auto slurm = backend();
  Order wanted = order();
  wanted.folder = "/jobs/%j 100%";
  slurm.launch(wanted);
  EXPECT_THAT(text("sbatch.asked"), HasSubstr("--chdir=/jobs/%j 100%\n"));
  EXPECT_THAT(text("sbatch.asked"), HasSubstr("--output=/jobs/%%j 100%%/keeper.err\n"));
  wanted = order(18);
  wanted.folder = "/jobs/a\\b";
  EXPECT_THROW(slurm.launch(wanted), base::Error);
}

TEST_F(SlurmBackendTest, RanksAreTasksOfACore) {
  auto slurm = backend();
  Order wanted = order();
  wanted.ranks = 8;
  wanted.memory_bytes = 8'000'000'000;
  slurm.launch(wanted);
  EXPECT_THAT(text("sbatch.asked"),
              HasSubstr("--ntasks=8\n--cpus-per-task=1\n--mem-per-cpu=1000M"));
  EXPECT_THAT(text("sbatch.asked"), Not(HasSubstr("--nodes")));
}

TEST_F(SlurmBackendTest, AsksSqueueOnceForAllAndNotSoonAgain) {
  write("queue",
        "1|RUNNING|None|sleight:abcdefgh:1:1\n2|PENDING|Resources|sleight:abcdefgh:2:1\n"
        "3|RUNNING|None|sleight:strangers:1:1\n");
  auto slurm = backend();
  EXPECT_EQ(slurm.list("abcdefgh").size(), 2U);
  for (std::uint64_t job = 1; job <= 50; ++job)
    slurm.state({.daemon = "abcdefgh", .job = job, .epoch = 1});
  for (std::uint64_t job = 100; job < 105; ++job)
    slurm.launch(order(job));
  EXPECT_EQ(slurm.list("abcdefgh").size(), 7U) << "what was submitted is there at once";
  EXPECT_EQ(slurm.list("strangers").size(), 1U);
  EXPECT_EQ(calls("squeue"), 1U);
  clock_.now = 9.9;
  slurm.list("abcdefgh");
  EXPECT_EQ(calls("squeue"), 1U);
  clock_.now = 10;
  EXPECT_EQ(slurm.list("abcdefgh").size(), 2U) << "as Slurm says it";
  EXPECT_EQ(calls("squeue"), 2U);
}

TEST_F(SlurmBackendTest, ALostAnswerIsFoundAgainByItsComment) {
  // Goal: if sbatch's answer is lost, the next launch finds the job in the queue and doesn't submit
  // it again. Method: sbatch submits the job, but then is killed, reports a timeout, or prints
  // nothing.
  for (const char* loss : {"kill -9 $$",
                           "echo 'sbatch: error: Batch job submission failed: Socket timed out on "
                           "send/recv operation' >&2; exit 1",
                           "true"}) {
    write("queue", "");
    program("sbatch",
            fmt::format("echo '5|PENDING|Priority|sleight:abcdefgh:17:3' > queue\n{}", loss));
    auto slurm = backend();
    const std::size_t before = calls("sbatch");
    try {
      slurm.launch(order());
      ADD_FAILURE() << loss;
    } catch (const Away& away) {
      EXPECT_TRUE(away.may_have_begun()) << loss;
    }
    EXPECT_EQ(slurm.launch(order()).id, "5") << loss;
    EXPECT_EQ(calls("sbatch"), before + 1) << loss;
  }
}

TEST_F(SlurmBackendTest, ALaunchThatNeverCameIsSubmittedAgain) {
  program("sbatch", "echo 'sbatch: error: Unable to contact slurm controller' >&2; exit 1");
  auto slurm = backend();
  EXPECT_THROW(slurm.launch(order()), Away);
  program("sbatch", "echo 813");
  EXPECT_EQ(slurm.launch(order()).id, "813");
}

TEST_F(SlurmBackendTest, ARefusalIsNoSilence) {
  program("sbatch",
          "echo 'sbatch: error: Batch job submission failed: Invalid account' >&2; exit 1");
  auto slurm = backend();
  try {
    slurm.launch(order());
    ADD_FAILURE();
  } catch (const Away&) {
    ADD_FAILURE() << "it answered";
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("Invalid account"));
  }
}

TEST_F(SlurmBackendTest, AControllerThatIsAwayIsAskedOnce) {
  // Goal: while squeue can't reach the controller, no job is submitted, and squeue runs only once
  // for twenty calls.
  program("squeue", "echo 'slurm_load_jobs error: Unable to contact slurm controller' >&2; exit 1");
  auto slurm = backend();
  for (std::uint64_t job = 1; job <= 10; ++job) {
    EXPECT_THROW(slurm.state(order(job).name), Away);
    try {
      slurm.launch(order(job));
      ADD_FAILURE();
    } catch (const Away& away) {
      EXPECT_FALSE(away.may_have_begun());
    }
  }
  EXPECT_EQ(calls("squeue"), 1U);
  EXPECT_EQ(calls("sbatch"), 0U);
  program("squeue", "cat queue");
  clock_.now = 10;
  EXPECT_EQ(slurm.launch(order()).id, "812");
}

TEST_F(SlurmBackendTest, ProgramsThatAreMissingAreAway) {
  std::filesystem::remove(path("squeue"));
  EXPECT_THROW(backend().list("abcdefgh"), Away);
}

TEST_F(SlurmBackendTest, SignalsReachWhatIsThere) {
  write("queue",
        "1|RUNNING|None|sleight:abcdefgh:1:3\n2|PENDING|Resources|sleight:abcdefgh:2:3\n"
        "3|FAILED|None|sleight:abcdefgh:3:3\n");
  auto slurm = backend();
  EXPECT_TRUE(slurm.signal(order(1).name, keeper::Stop::in_order));
  EXPECT_TRUE(slurm.signal(order(2).name, keeper::Stop::in_order));
  EXPECT_FALSE(slurm.signal(order(3).name, keeper::Stop::now));
  EXPECT_FALSE(slurm.signal(order(4).name, keeper::Stop::now));
  EXPECT_TRUE(slurm.signal(order(1).name, keeper::Stop::now));
  EXPECT_EQ(text("scancel.asked"), "--signal=USR1\n--batch\n1\n--state=PENDING\n2\n1\n");
}

TEST_F(SlurmBackendTest, WhatWasCancelledByItselfIsNobodyElsesDoing) {
  write("queue", "1|RUNNING|None|sleight:abcdefgh:1:3\n2|RUNNING|None|sleight:abcdefgh:2:3\n");
  auto slurm = backend();
  slurm.signal(order(1).name, keeper::Stop::now);
  write("queue", "1|CANCELLED|None|sleight:abcdefgh:1:3\n2|CANCELLED|None|sleight:abcdefgh:2:3\n");
  clock_.now = 10;
  EXPECT_EQ(slurm.state(order(1).name).cause, Cause::itself);
  EXPECT_EQ(slurm.state(order(2).name).cause, Cause::cancelled);
}

TEST_F(SlurmBackendTest, ASignalToWhatHasJustEndedIsNoError) {
  write("queue", "1|RUNNING|None|sleight:abcdefgh:1:3\n");
  auto slurm = backend();
  program(
      "scancel",
      "echo 'scancel: error: Kill job error on job id 1: Invalid job id specified' >&2; exit 1");
  EXPECT_FALSE(slurm.signal(order(1).name, keeper::Stop::now));
  program("scancel", "echo 'scancel: error: Unable to contact slurm controller' >&2; exit 1");
  EXPECT_THROW(slurm.signal(order(1).name, keeper::Stop::now), Away);
}

TEST_F(SlurmBackendTest, WrongDefaultsAreRefusedAtOnce) {
  EXPECT_THROW(backend({{"more", "--comment=x"}}), base::Error);
  auto slurm = backend();
  Order wanted = order();
  wanted.options = {{"more", "--wrap=x"}};
  EXPECT_THROW(slurm.launch(wanted), base::Error);
  EXPECT_EQ(calls("sbatch"), 0U);
}

}  // namespace
}  // namespace sleight::backend
