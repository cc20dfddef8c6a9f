// Goal: each row that squeue prints for an attempt is read as the attempt's state. Rows of other
// jobs and damaged rows are ignored.
#include "service/backend/slurm_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sleight::backend {
namespace {

using ::testing::ElementsAre;

const AttemptName k_first{.daemon = "abcdefgh", .job = 17, .epoch = 3};

TEST(SlurmQueue, HasTheAttemptsOfComments) {
  const SlurmQueue queue = slurm_queue_of(
      "812|PENDING|Priority|sleight:abcdefgh:17:3\n"
      "813|RUNNING|None|sleight:abcdefgh:18:1\n"
      "814|TIMEOUT|TimeLimit|sleight:abcdefgh:19:1\n");
  ASSERT_EQ(queue.size(), 3U);
  EXPECT_EQ(queue.at(k_first).front().seen,
            (Seen{.state = State::waiting, .id = "812", .words = "Priority"}));
  const Seen& timeout = queue.at({.daemon = "abcdefgh", .job = 19, .epoch = 1}).front().seen;
  EXPECT_EQ(timeout.state, State::gone);
  EXPECT_EQ(timeout.words, "TIMEOUT (TimeLimit)");
}

TEST(SlurmQueue, PassesOddRowsOver) {
  // Method: read rows of foreign jobs, incomplete rows, and a job array. One comment contains a
  // vertical bar. The last row has no newline.
  const SlurmQueue queue = slurm_queue_of(
      "\n|||\nslurm_load_jobs error\n"
      "1|RUNNING|None|my own|words\n"
      "2|RUNNING|None|\n"
      "3|RUNNING|None\n"
      "4_[1-9]|PENDING|Priority|sleight:abcdefgh:17:3\n"
      "5|RUNNING|None|sleight:abcdefgh:17:3|x\n"
      "6|RUNNING|None|sleight:abcdefgh:17:3");
  ASSERT_EQ(queue.size(), 1U);
  ASSERT_EQ(queue.at(k_first).size(), 1U);
  EXPECT_EQ(queue.at(k_first).front().id, "6");
}

TEST(SlurmQueue, KnowsEveryState) {
  for (const char* state : {"PENDING", "REQUEUED", "REQUEUE_HOLD", "SPECIAL_EXIT"})
    EXPECT_EQ(seen_of_slurm(state, "").state, State::waiting) << state;
  for (const char* state : {"RUNNING", "CONFIGURING", "COMPLETING", "SUSPENDED", "STOPPED"})
    EXPECT_EQ(seen_of_slurm(state, "").state, State::running) << state;
  for (const char* state : {"COMPLETED", "FAILED", "TIMEOUT", "OUT_OF_MEMORY", "DEADLINE"}) {
    EXPECT_EQ(seen_of_slurm(state, "").state, State::gone) << state;
    EXPECT_EQ(seen_of_slurm(state, "").cause, Cause::itself) << state;
  }
  for (const char* state : {"PREEMPTED", "NODE_FAIL", "BOOT_FAIL"})
    EXPECT_EQ(seen_of_slurm(state, "").cause, Cause::taken) << state;
  EXPECT_EQ(seen_of_slurm("FAILED", "NodeDown").cause, Cause::taken);
  EXPECT_EQ(seen_of_slurm("FAILED", "NonZeroExitCode").cause, Cause::itself);
  EXPECT_EQ(seen_of_slurm("CANCELLED", "").cause, Cause::cancelled);
  EXPECT_EQ(seen_of_slurm("HIBERNATING", "").state, State::unknown) << "of a later Slurm";
}

TEST(SlurmQueue, OfSeveralJobsOfAnAttemptTheOneThatRunsTells) {
  const SlurmQueue queue = slurm_queue_of(
      "100|FAILED|NonZeroExitCode|sleight:abcdefgh:17:3\n"
      "99|RUNNING|None|sleight:abcdefgh:17:3\n"
      "9|COMPLETED|None|sleight:abcdefgh:17:3\n");
  const auto& jobs = queue.at(k_first);
  ASSERT_EQ(jobs.size(), 3U);
  EXPECT_EQ(jobs.front().id, "9");
  EXPECT_EQ(telling_one(jobs).id, "99");
  const SlurmQueue ended = slurm_queue_of(
      "100|TIMEOUT|TimeLimit|sleight:abcdefgh:17:3\n"
      "99|COMPLETED|None|sleight:abcdefgh:17:3\n");
  EXPECT_EQ(telling_one(ended.at(k_first)).id, "100");
}

TEST(SlurmQueue, NumbersOfSbatch) {
  EXPECT_EQ(slurm_number_in("812\n"), "812");
  EXPECT_EQ(slurm_number_in("812;cluster\n"), "812");
  EXPECT_EQ(slurm_number_in("Welcome!\n812\n"), "812");
  EXPECT_EQ(slurm_number_in("Submitted batch job 812\n"), "");
  EXPECT_EQ(slurm_number_in(""), "");
}

}  // namespace
}  // namespace sleight::backend
