#include "clients/service_client/job_names.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sleight::service_client {
namespace {

TEST(JobNames, AreNumbersRangesAndGroups) {
  // Goal: a number, a range and a group are parsed as job names. Each name prints as the text that
  // was parsed.
  const std::vector<std::string> texts{"17", "3..8", "g5"};
  const auto names = job_names_of(texts);
  ASSERT_TRUE(names);
  EXPECT_EQ(names.value(), (std::vector<JobName>{rpc::JobId{17}, JobRange{3, 8}, rpc::GroupId{5}}));
  for (std::size_t i = 0; i < texts.size(); ++i)
    EXPECT_EQ(to_string(names.value()[i]), texts[i]);
}

TEST(JobNames, OtherTextsAreNone) {
  // Goal: a text that isn't exactly a job name is refused, and the error contains no control
  // characters.
  for (const char* text : {"",
                           "0",
                           "-1",
                           "+1",
                           " 17",
                           "17 ",
                           "1.5",
                           "g",
                           "g0",
                           "G5",
                           "g-1",
                           "5g",
                           "..",
                           "3..",
                           "..8",
                           "8..3",
                           "3...8",
                           "0..3",
                           "1e3",
                           "0x11",
                           "18446744073709551616",
                           "g18446744073709551616",
                           "1..10001",
                           "\x1b[2J"}) {
    const std::vector<std::string> texts{"17", text};
    const auto names = job_names_of(texts);
    ASSERT_FALSE(names) << text;
    EXPECT_EQ(names.error().find('\x1b'), std::string::npos);
  }
}

TEST(JobNames, ARangeIsBounded) {
  // Goal: a range of 10,000 jobs is accepted, and a longer range is refused.
  EXPECT_TRUE(job_names_of(std::vector<std::string>{"1..10000"}));
  EXPECT_FALSE(job_names_of(std::vector<std::string>{"2..10002"}));
}

TEST(JobNames, OnlyANumberAloneIsASingleJob) {
  // Goal: only one plain number counts as a single job. A group and a range of one job count as
  // lists.
  const auto is_single = [](const std::vector<std::string>& texts) {
    return is_single_job(job_names_of(texts).value());
  };
  EXPECT_TRUE(is_single({"17"}));
  EXPECT_FALSE(is_single({"17..17"}));
  EXPECT_FALSE(is_single({"g5"}));
  EXPECT_FALSE(is_single({"17", "18"}));
}

}  // namespace
}  // namespace sleight::service_client
