// Goal: lists and views of jobs fit a terminal, show each count separately, and omit nothing.
// Method: make jobs with values of all kinds, and compare their printed lines with the expected
// lines.
#include "clients/cli/job_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "clients/service_client/event_words.h"

namespace sleight::cli {
namespace {

class JobText : public testing::Test {
 protected:
  JobText() {
    ::setenv("TZ", "UTC", 1);
    ::tzset();
  }
};

rpc::JobView running_job() {
  return {
      .id = {17},
      .group = rpc::GroupId{5},
      .name = "hi",
      .world = "spelling",
      .state = rpc::JobState::running,
      .reason = "goes on from scan 400",
      .attempt = 2,
      .cores_wanted = 4,
      .cores = 2,
      .strict = true,
      .scans_done = 12'400,
      .scans_total = 40'000,
      .solutions = {.found = 5, .found_wanted = 5, .in_proportion = 3, .in_proportion_wanted = 50},
      .failures = {{"search_gave_up", 2}, {"work_limit", 1}},
      .simulations_per_s = 85'200.4,
      .left_s = 4,
      .solutions_left_s = 4800,
      .core_s = 750,
      .submitted_s = 1'795'669'960,
      .started_s = 1'795'669'961,
      .bytes = 12'000'000,
      .history = {{.number = 1,
                   .time_s = 1'795'669'960,
                   .state = rpc::JobState::queued,
                   .reason = "submitted"},
                  {.number = 2,
                   .time_s = 1'795'669'961,
                   .state = rpc::JobState::running,
                   .reason = "cores are free",
                   .attempt = 1}}};
}

rpc::JobView queued_job() {
  return {.id = {18},
          .user = 1000,
          .name = "throws",
          .world = "ball_2d",
          .state = rpc::JobState::queued,
          .reason = "submitted",
          .place = 3,
          .not_yet = "waits for 4 cores; 2 are free"};
}

TEST_F(JobText, TableHasWhatPeopleAskFor) {
  // Goal: a job table has two columns for the time left, one by scans and one by solutions. Finds
  // and draws have separate columns. The table shows a queued job's place with the reason, and
  // failures by kind.
  const std::vector<rpc::JobView> jobs{running_job(), queued_job()};
  EXPECT_EQ(job_table(jobs, {}),
            "ID  NAME    GROUP  STATE    PLACE              SCANS  FOUND  IN PROPORTION  SIMS/S  "
            "LEFT  TO SOLUTIONS  FAILED                          WHY\n"
            "17  hi      g5     running         12,400/40,000 31%    5/5           3/50  85,200  "
            "0:04       1:20:00  search_gave_up 2, work_limit 1\n"
            "18  throws         queued       3                                                   "
            "                                                    waits for 4 cores; 2 are free\n");
}

TEST_F(JobText, TableNamesUsersWhereAsked) {
  // Goal: a job table can show users by name, and cuts lines that are too long.
  const std::vector<rpc::JobView> jobs{queued_job()};
  const std::string text =
      job_table(jobs, {.width = 60, .with_users = true, .user_name = [](std::uint32_t uid) {
                         return uid == 1000 ? "ada" : "?";
                       }});
  EXPECT_EQ(text,
            "ID  NAME    USER  STATE   PLACE  WHY\n"
            "18  throws  ada   queued      3  waits for 4 cores; 2 are...\n");
}

TEST_F(JobText, StatusOfAFailedJobSaysWhatRepeatsIt) {
  // Goal: the text of a failed job shows the reason, the log's last lines and the command to repeat
  // the job.
  rpc::JobView job = queued_job();
  job.state = rpc::JobState::failed;
  job.place = 0;
  job.not_yet = "";
  job.reason = "died five times without a commit between";
  job.last_log_lines = {"first line", "last line"};
  job.repeat_command = "sleight direct request.toml -o out.h5";
  job.deleted_at_s = 1'795'669'960;
  const std::string text = job_text(job);
  EXPECT_NE(text.find("state         failed: died five times without a commit between\n"),
            std::string::npos);
  EXPECT_NE(text.find("  log           first line\n  log           last line\n"),
            std::string::npos);
  EXPECT_NE(text.find("to repeat     sleight direct request.toml -o out.h5\n"), std::string::npos);
  EXPECT_NE(text.find("deleted after 2026-11-26 05:12:40;"), std::string::npos);
  EXPECT_NE(text.find("`sleight pin 18`"), std::string::npos);
}

TEST_F(JobText, NothingOfTheServiceSteersTheTerminal) {
  // Goal: text from other people or programs can't control the terminal. Method: put escape
  // sequences, line ends and bidirectional marks into every field. The output may contain no
  // bidirectional marks, and no control characters except line ends and tabs.
  const std::string evil = "a\x1b[2Jb\nc\rd\te\u202ef\u0085g\x7f";
  rpc::JobView job = running_job();
  job.name = job.world = job.reason = job.not_yet = job.digest = job.end_words = evil;
  job.repeat_command = evil;
  job.last_log_lines = {evil};
  job.failures = {{evil, 1}};
  job.history = {{.number = 1, .time_s = 1, .state = rpc::JobState::queued, .reason = evil}};
  for (const rpc::JobState state : {rpc::JobState::running, rpc::JobState::queued,
                                    rpc::JobState::failed, rpc::JobState::unknown}) {
    job.state = state;
    const std::vector<rpc::JobView> jobs{job};
    const std::string text =
        job_text(job) + history_text(job) + end_line(job) +
        job_table(jobs, {.with_users = true, .user_name = [&](std::uint32_t) { return evil; }}) +
        touched_line({.job = {1}, .state = state, .words = evil}) + completion_line(job) +
        service_client::words_of_event({1}, {.what = events::Phase{evil}}) +
        service_client::words_of_event({1}, {.what = events::RunEnd{.words = evil}}) +
        service_client::words_of_change(job.history.front());
    EXPECT_EQ(std::ranges::count(text, '\x1b'), 0);
    EXPECT_EQ(std::ranges::count(text, '\r'), 0);
    EXPECT_EQ(std::ranges::count(text, '\x7f'), 0);
    EXPECT_EQ(std::ranges::count(text, '\t'), 1) << "of the completion line";
    EXPECT_EQ(text.find("\u202e"), std::string::npos);
    EXPECT_EQ(text.find("\u0085"), std::string::npos);
    EXPECT_EQ(text.find("b\nc"), std::string::npos);
  }
}

TEST_F(JobText, NumbersOfABrokenServiceAreShownAsNothing) {
  // Goal: extreme times and rates don't break a line. Method: use huge positive and negative
  // numbers, and NaN.
  rpc::JobView job = queued_job();
  for (const double wild : {1e300, -1e300, 0.0 / 0.0}) {
    job.simulations_per_s = wild;
    job.submitted_s = job.started_s = job.ended_s = job.deleted_at_s = wild;
    job.left_s = job.solutions_left_s = job.core_s = wild;
    EXPECT_NE(job_text(job).find("submitted -"), std::string::npos);
  }
}

}  // namespace
}  // namespace sleight::cli
