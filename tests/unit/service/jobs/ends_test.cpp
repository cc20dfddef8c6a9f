// Goal: each end of an attempt leads to the state, the reason and the delay that ends.h defines.
#include "service/jobs/ends.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/base/error.h"
#include "service/jobs/turns.h"

namespace sleight::jobs {
namespace {

using base::ExitCode;

Job running_job() {
  Job job;
  job.id = JobId{17};
  job.state = State::running;
  job.reason = Reason::began;
  job.attempt = Attempt{3};
  job.attempt_revision = 1;
  job.counts.scans = 10;
  job.scans_at_attempt = 5;
  return job;
}

Job yielding_job(Reason reason) {
  Job job = running_job();
  job.state = State::yielding;
  job.reason = reason;
  return job;
}

Verdict judged(const Job& job, const Ended& ended, const Surroundings& around = {}) {
  return judge(job, ended, around, Options{});
}

Ended error(ExitCode code) {
  return {.kind = EndKind::failed, .exit_code = static_cast<int>(code), .words = "words"};
}

TEST(Ends, MeanWhatTheRecordSays) {
  struct Row {
    Ended ended;
    State to;
    Reason reason;
    bool backs_off;
  };
  const std::vector<Row> rows{
      {{.kind = EndKind::finished, .exit_code = 139}, State::done, Reason::finished, false},
      {{.kind = EndKind::gave_up}, State::failed, Reason::gave_up, false},
      {{.kind = EndKind::no_draws}, State::failed, Reason::no_draws, false},
      {{.kind = EndKind::simulation_failed}, State::failed, Reason::simulation_failed, false},
      {{.kind = EndKind::time_limit}, State::queued, Reason::stopped_by_itself, false},
      {{.kind = EndKind::stop_requested}, State::queued, Reason::stopped_by_itself, false},
      {error(ExitCode::bad_request), State::failed, Reason::refused_by_program, false},
      {error(ExitCode::usage), State::failed, Reason::refused_by_program, false},
      {error(ExitCode::environment), State::queued, Reason::died, true},
      {error(ExitCode::conflict), State::queued, Reason::died, true},
      {{.kind = EndKind::failed, .hindrance = Hindrance::disk_full},
       State::held,
       Reason::disk_full,
       true},
      {{.kind = EndKind::failed, .hindrance = Hindrance::other_results},
       State::held,
       Reason::other_results,
       true},
      {{.kind = EndKind::failed, .hindrance = Hindrance::store_damaged},
       State::failed,
       Reason::refused_by_program,
       false},
      {{.kind = EndKind::bug, .place = "a.cpp:1"}, State::queued, Reason::died, true},
      {{.kind = EndKind::none, .exit_code = 0}, State::queued, Reason::died, true},
      {{.kind = EndKind::none, .signal = 9}, State::queued, Reason::died, true},
  };
  for (const Row& row : rows) {
    const Verdict verdict = judged(running_job(), row.ended);
    EXPECT_EQ(verdict.to, row.to) << name_of(row.ended.kind);
    EXPECT_EQ(verdict.reason, row.reason) << name_of(row.ended.kind);
    EXPECT_EQ(verdict.backs_off, row.backs_off) << name_of(row.ended.kind);
  }
}

TEST(Ends, MeanWhatTheSurroundingsExplain) {
  // If a program can't write, it reports only the system's error, but the daemon may see the cause.
  EXPECT_EQ(judged(running_job(), error(ExitCode::environment), {.is_disk_low = true}).reason,
            Reason::disk_full);
  EXPECT_EQ(judged(running_job(), error(ExitCode::conflict), {.has_other_results = true}).reason,
            Reason::other_results);
}

TEST(Ends, AreWhatTheStopWasFor) {
  const Ended stopped{.kind = EndKind::stop_requested, .exit_code = 130};
  const Ended killed{.signal = 9};
  const Ended finished{.kind = EndKind::finished};
  const Ended refused = error(ExitCode::bad_request);
  struct Row {
    Reason asked;
    State stopped;
    State killed;
    State refused;
  };
  const std::vector<Row> rows{
      {Reason::cancel_asked, State::cancelled, State::cancelled, State::cancelled},
      {Reason::hold_asked, State::held, State::held, State::failed},
      {Reason::disk_low, State::held, State::held, State::failed},
      {Reason::others_wait, State::queued, State::queued, State::failed},
      {Reason::draining, State::queued, State::queued, State::failed}};
  for (const Row& row : rows) {
    const Job job = yielding_job(row.asked);
    EXPECT_EQ(judged(job, stopped).to, row.stopped) << name_of(row.asked);
    EXPECT_EQ(judged(job, stopped).reason, row.asked);
    EXPECT_EQ(judged(job, killed).to, row.killed) << name_of(row.asked);
    EXPECT_EQ(judged(job, refused).to, row.refused) << name_of(row.asked);
    EXPECT_EQ(judged(job, finished).to, State::done) << name_of(row.asked);
  }
}

TEST(Ends, GivingUpWithFindsIsDone) {
  Job job = running_job();
  job.counts.found = 2;
  EXPECT_EQ(judged(job, {.kind = EndKind::gave_up}).to, State::done);
}

TEST(Ends, AnExtendedJobGoesOn) {
  Job job = running_job();
  job.revision = 2;
  EXPECT_EQ(judged(job, {.kind = EndKind::finished}).to, State::queued);
  EXPECT_EQ(judged(job, {.kind = EndKind::finished}).reason, Reason::extended);
}

/// Lets an attempt die `deaths` times. Before each death, the attempt commits `commits` scans.
/// Returns the delay after each death.
std::vector<double> waits_of_deaths(Job& job, int deaths, std::uint64_t commits) {
  std::vector<double> waits;
  for (int i = 0; i < deaths; ++i) {
    job.scans_at_attempt = job.counts.scans;
    job.counts.scans += commits;
    const Verdict verdict =
        judge(job, Died{.log_end = "the log", .repeat = "sleight x"}, Options{});
    waits.push_back(count_end(job, verdict, {}, 1, Options{}));
    job.state = verdict.to == State::failed ? State::failed : State::running;
  }
  return waits;
}

TEST(Ends, FiveDeathsWithoutACommitAreEnough) {
  Job job = running_job();
  EXPECT_THAT(waits_of_deaths(job, 5, 0), testing::ElementsAre(1, 2, 4, 8, 0));
  EXPECT_EQ(job.state, State::failed);
  Job other = running_job();
  waits_of_deaths(other, 4, 0);
  const Verdict last = judge(other, Died{.log_end = "the log", .repeat = "sleight x"}, Options{});
  EXPECT_THAT(last.words,
              testing::AllOf(testing::HasSubstr("5 times"), testing::HasSubstr("the log"),
                             testing::HasSubstr("sleight x")));
}

TEST(Ends, DeathsWithCommitsBetweenWaitLongerAndLonger) {
  Job job = running_job();
  EXPECT_THAT(waits_of_deaths(job, 11, 1),
              testing::ElementsAre(1, 2, 4, 8, 16, 32, 64, 128, 256, 300, 300));
  EXPECT_EQ(job.deaths, 1U);
  // An attempt that lived long resets the delay.
  const Verdict verdict = judge(job, Died{}, Options{});
  EXPECT_EQ(count_end(job, verdict, {}, 1e4, Options{}), 1);
}

TEST(Ends, ABugTwiceAtOnePlaceFails) {
  const Ended bug{.kind = EndKind::bug, .words = "1 against 2", .place = "a.cpp:1"};
  Job job = running_job();
  const auto happens = [&](const Ended& ended) {
    const Verdict verdict = judged(job, ended);
    count_end(job, verdict, ended.place, 1, Options{});
    return verdict;
  };
  EXPECT_EQ(happens(bug).to, State::queued);
  job.scans_at_attempt = job.counts.scans++;
  EXPECT_EQ(happens(bug).to, State::queued) << "a commit is between";
  EXPECT_EQ(happens({.kind = EndKind::bug, .place = "b.cpp:1"}).to, State::queued);
  EXPECT_EQ(happens(bug).to, State::queued) << "another place is between";
  EXPECT_EQ(happens(bug).to, State::failed);
  EXPECT_EQ(judged(job, bug).reason, Reason::bug);
}

TEST(Turns, GiveSharesFirst) {
  Job job = running_job();
  const Need need = need_of(job, {.cores = 10, .users = 2}, 0, 10);
  EXPECT_EQ(need.cores, 5U);
  EXPECT_EQ(cores_given(need, 10, 5), 5U) << "another user waits";
  EXPECT_EQ(cores_given(need, 10, 1), 9U) << "for one core";
  EXPECT_EQ(cores_given(need, 10, 0), 10U) << "nobody does";
  EXPECT_EQ(cores_given(need, 3, 9), 3U) << "less is free";
  job.wishes.ranks = 8;
  EXPECT_EQ(need_of(job, {.cores = 10, .users = 2}, 0, 8).cores_min, 8U);
}

TEST(Turns, SlicesPayForRestarts) {
  const Options options;
  Job job = running_job();
  EXPECT_EQ(slice_s(job, options), 10) << "half a second, as long as it isn't measured";
  job.start_cost_s = 2;
  job.stop_cost_s = 1;
  EXPECT_EQ(slice_s(job, options), 60);
  job.scans_at_attempt = job.counts.scans;
  job.fruitless = 3;
  EXPECT_EQ(slice_s(job, options), 480) << "nothing committed yet";
}

}  // namespace
}  // namespace sleight::jobs
