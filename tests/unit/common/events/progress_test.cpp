#include "common/events/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/facts.h"

namespace sleight::events {
namespace {

using ::testing::ElementsAre;

/// Returns the numbers in a line, in order. A number includes its signs and separators.
std::vector<std::string> numbers_of(const std::string& line) {
  constexpr std::string_view k_signs = "0123456789,.:%+-";
  std::vector<std::string> numbers;
  for (std::size_t at = line.find(' '); at < line.size();) {
    at = line.find_first_of(k_signs, at);
    if (at == std::string::npos) break;
    const std::size_t end = std::min(line.find_first_not_of(k_signs, at), line.size());
    const std::string token = line.substr(at, end - at);
    const std::size_t size = token.find_last_of("0123456789%") + 1;
    if (size > 0) numbers.push_back(token.substr(0, size));
    at = end;
  }
  return numbers;
}

TEST(Grouped, GroupsByThousands) {
  // Goal: large counts are printed in groups of three digits.
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(12345), "12,345");
  EXPECT_EQ(grouped(123456), "123,456");
  EXPECT_EQ(grouped(1234567), "1,234,567");
  EXPECT_EQ(grouped(std::numeric_limits<std::uint64_t>::max()), "18,446,744,073,709,551,615");
}

TEST(ClockTime, ShowsMinutesAndHours) {
  // Goal: a time is rounded up and printed as minutes and seconds, and hours if there are any.
  // Invalid times are printed as 0:00 or as the longest time.
  EXPECT_EQ(clock_time(0), "0:00");
  EXPECT_EQ(clock_time(0.2), "0:01");
  EXPECT_EQ(clock_time(4), "0:04");
  EXPECT_EQ(clock_time(59.5), "1:00");
  EXPECT_EQ(clock_time(750), "12:30");
  EXPECT_EQ(clock_time(3599), "59:59");
  EXPECT_EQ(clock_time(3600), "1:00:00");
  EXPECT_EQ(clock_time(11100), "3:05:00");
  EXPECT_EQ(clock_time(-5), "0:00");
  EXPECT_EQ(clock_time(std::numeric_limits<double>::quiet_NaN()), "0:00");
  EXPECT_EQ(clock_time(1e30), clock_time(std::numeric_limits<double>::infinity()));
}

TEST(ProgressLine, IsAsItsHeaderShows) {
  // Goal: the progress line contains the numbers of the example in progress.h.
  const Progress progress{.scans_done = 12400,
                          .scans_total = 40000,
                          .session_scans = 8520,
                          .session_satisfied = 4431,
                          .session_proposed = 8500,
                          .session_accepted = 3485,
                          .session_simulations = 7310,
                          .solutions = 4,
                          .round_trips = 12,
                          .workers = 4,
                          .elapsed_s = 0.1};
  EXPECT_THAT(numbers_of(progress_line("ball_2d", progress)),
              ElementsAre("12,400", "40,000", "31%", "0:01", "73,100", "4", "12", "4,431", "52%",
                          "41%", "4"));
}

TEST(ProgressLine, TellsTheOddsSoFar) {
  // Goal: a run that estimates odds shows the estimate, its error and the remaining time. Method:
  // print the progress line before any island is done, after 1 island, after 41 of 132 islands, and
  // after the run.
  Progress progress{.odds = {.are_asked = true}, .workers = 2, .elapsed_s = 1};
  EXPECT_THAT(numbers_of(progress_line("x", progress)), ElementsAre("0", "0", "2"));
  progress.odds = {.are_asked = true, .islands = 1, .log_p = -39.14};
  EXPECT_THAT(odds_in_words(progress.odds), tests::HasFacts("-39.1|rough|1 island"));
  progress.scans_done = 41;
  progress.scans_total = 132;
  progress.session_scans = 41;
  progress.session_simulations = 7000;
  progress.odds = {
      .are_asked = true, .islands = 41, .wanted = 132, .log_p = -39.14, .log_error = 0.43};
  EXPECT_THAT(numbers_of(progress_line("x", progress)),
              ElementsAre("-39.1", "0.4", "41", "132", "0:03", "7,000", "2"));
  progress.odds = {.are_asked = true,
                   .islands = 100,
                   .wanted = 132,
                   .log_p = -39.14,
                   .log_error = 0.214,
                   .is_final = true};
  EXPECT_EQ(odds_in_words(progress.odds), "log P -39.14 +- 0.21 (100 islands)");
}

TEST(ProgressLine, TellsFailures) {
  // Goal: the total number of failures is near the line's beginning, so that narrow terminals show
  // it.
  const Progress progress{.scans_done = 10, .failures = {.by_kind = {1200, 0, 0, 0, 34, 0}}};
  EXPECT_THAT(progress_line("x", progress), ::testing::StartsWith("x  10 scans  1,234 FAILED  0"));
}

TEST(ProgressLine, LeavesOutWhatIsNotKnown) {
  // Goal: the line omits numbers that are not known yet. Method: print four lines: nothing has
  // happened, the total number of scans is unknown, all scans are done, and no scan of this session
  // is done.
  EXPECT_THAT(numbers_of(progress_line("x", {})), ElementsAre("0", "0", "0", "0", "0%", "0%", "0"));
  EXPECT_THAT(numbers_of(progress_line("x", {.scans_done = 1500,
                                             .session_scans = 1000,
                                             .session_simulations = 1000,
                                             .workers = 1,
                                             .elapsed_s = 2})),
              ElementsAre("1,500", "500", "0", "0", "0%", "0%", "1"));
  EXPECT_THAT(
      numbers_of(progress_line(
          "x", {.scans_done = 100, .scans_total = 100, .session_scans = 100, .elapsed_s = 1})),
      ElementsAre("100", "100", "100%", "0", "0", "0", "0%", "0%", "0"));
  EXPECT_THAT(
      numbers_of(progress_line("x", {.scans_done = 50, .scans_total = 100, .elapsed_s = 1})),
      ElementsAre("50", "100", "50%", "0", "0", "0", "0%", "0%", "0"));
}

TEST(ProgressLine, CountsWhatASearchDoes) {
  // Goal: the line of a search counts finds, relaxed finds, simulations and draws of the prior.
  // Method: print the line three times: nothing is found, two of five finds are found, and one find
  // has been relaxed.
  Progress search{.finds = {.wanted = 5, .is_all = true}, .workers = 2, .elapsed_s = 12};
  EXPECT_THAT(numbers_of(progress_line("x", search)), ElementsAre("0", "5", "0.0", "0:12", "2"));
  search.session_simulations = 600;
  search.finds.found = 2;
  search.found_s = 3;
  EXPECT_THAT(numbers_of(progress_line("x", search)),
              ElementsAre("2", "5", "3.0", "600", "50", "2"));
  search.finds.found = search.finds.wanted = 6;
  search.finds.relaxed = 1;
  search.finds.relaxed_wanted = 5;
  search.scans_done = 100;
  search.scans_total = 400;
  search.session_scans = 60;
  search.prior_draws = 40;
  search.prior_draws_wanted = 100;
  EXPECT_THAT(numbers_of(progress_line("x", search)),
              ElementsAre("6", "3.0", "1", "5", "100", "400", "25%", "1:00", "600", "50", "40",
                          "100", "2"));
}

TEST(ProgressLine, HundredPercentMeansDone) {
  // Goal: the line shows 100% only after the last scan.
  const std::string line =
      progress_line("x", {.scans_done = 99'999'999, .scans_total = 100'000'000});
  EXPECT_NE(line.find("(99%)"), std::string::npos) << line;
}

}  // namespace
}  // namespace sleight::events
