// Goal: a job's record in the job store has all fields of the job, and invalid records are refused.
// Method: read back a job whose fields are all set. Count the fields to notice if one is forgotten.
#include "service/daemon/job_records.h"
#include "common/json/value.h"

#include <gtest/gtest.h>

#include "tests/unit/service/daemon/example_jobs.h"

namespace sleight::daemon {
namespace {

TEST(JobRecords, ReadBackWhatWasWritten) {
  const jobs::Job job = testing::full_job(17);
  EXPECT_EQ(job_of(to_line(job)), job);
  EXPECT_EQ(job_of(to_line(jobs::Job{})), jobs::Job{});
  const jobs::Change change{.id = jobs::JobId{17},
                            .from = jobs::State::running,
                            .to = jobs::State::queued,
                            .reason = jobs::Reason::died,
                            .attempt = jobs::Attempt{3},
                            .wall = 1e9,
                            .words = "in vain"};
  EXPECT_EQ(change_of(to_line(change)), change);
  const jobs::Usage usage{
      .user = jobs::UserId{5}, .at_s = 1.5, .share_core_s = 1e6 / 7, .allowance_core_s = 2};
  EXPECT_EQ(usage_of(to_line(usage)), usage);
}

// The structured binding compiles only if it has the right number of fields. One field is optional.
TEST(JobRecords, HaveEveryField) {
  const jobs::Job job = testing::full_job(1);
  const auto written = json::Value::parse(to_line(job)).size();
  [[maybe_unused]] const auto& [f01, f02, f03, f04, f05, f06, f07, f08, f09, f10, f11, f12, f13,
                                f14, f15, f16, f17, f18, f19, f20, f21, f22, f23, f24, f25, f26,
                                f27, f28, f29, f30, f31, f32, f33, f34, f35, f36, f37, f38, f39,
                                f40, f41, f42, f43] = job;
  EXPECT_EQ(written, 43U);
}

TEST(JobRecords, RefuseWhatWasNotWrittenHere) {
  for (const char* line : {"", "{", "[]", "3", R"({"state": "asleep"})", R"({"cores": -1})",
                           R"({"cores": 4294967296})", R"({"name": 7})"})
    EXPECT_FALSE(job_of(line).has_value()) << line;
}

}  // namespace
}  // namespace sleight::daemon
