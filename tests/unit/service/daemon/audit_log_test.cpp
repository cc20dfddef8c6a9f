// Goal: the audit log records all calls, and its size stays within a limit, even if attackers send
// many calls.
#include "service/daemon/audit_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/base/clock.h"
#include "common/json/value.h"
#include "common/logging/log.h"

namespace sleight::daemon {
namespace {

using ::testing::HasSubstr;

class AuditLogTest : public ::testing::Test {
 protected:
  AuditLogTest()
      : folder_(std::filesystem::temp_directory_path() /
                ("audit-" + std::to_string(::getpid()) + "-" +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
  }
  ~AuditLogTest() override { std::filesystem::remove_all(folder_); }

  std::vector<json::Value> lines(const char* name = "audit.log") const {
    std::vector<json::Value> read;
    std::ifstream file(folder_ / name);
    for (std::string line; std::getline(file, line);)
      read.push_back(json::Value::parse(line));
    return read;
  }
  /// A user with a token, on another machine.
  const rpc::Caller far_{.user = 4001, .address = "192.0.2.7:5", .token_id = "0123456789"};
  std::filesystem::path folder_;
  base::ManualClock clock_;
  AuditLog audit_{folder_, clock_, 4000};
};

TEST_F(AuditLogTest, ALineSaysWhoDidWhat) {
  audit_.note({.user = 4001, .pid = 7},
              {.call = "submit", .of = "2 jobs", .outcome = "done", .made = "1 2"});
  audit_.note(far_, {.call = "cancel", .of = "g5", .outcome = "not_allowed: No."});
  const auto read = lines();
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0]["call"], "submit");
  EXPECT_EQ(read[0]["from"], "process 7");
  EXPECT_EQ(read[0]["of"], "2 jobs");
  EXPECT_EQ(read[0]["outcome"], "done");
  EXPECT_EQ(read[0]["made"], "1 2");
  EXPECT_EQ(read[1]["call"], "cancel");
  EXPECT_EQ(read[1]["user"], 4001);
  EXPECT_EQ(read[1]["from"], "192.0.2.7:5");
  EXPECT_EQ(read[1]["token"], "0123456789");
  EXPECT_EQ(read[1]["of"], "g5");
  EXPECT_EQ(read[1]["outcome"], "not_allowed: No.");
}

// If logins have wrong tokens, the log gets at most one line per second. The lines count all these
// logins.
TEST_F(AuditLogTest, StrangersCantFillTheLog) {
  for (int i = 0; i < 1000; ++i) {
    audit_.note_stranger("203.0.113.9:1");
    clock_.advance(0.01);
  }
  clock_.advance(1);
  audit_.flush();
  std::uint64_t times = 0;
  for (const auto& line : lines())
    times += line.value("times", 1);
  EXPECT_LE(lines().size(), 12U);
  EXPECT_EQ(times, 1000U);
}

TEST_F(AuditLogTest, TheLogIsBounded) {
  for (int i = 0; i < 200; ++i)
    audit_.note({.user = 4001, .pid = i}, {.call = "submit", .outcome = "done"});
  EXPECT_LE(std::filesystem::file_size(folder_ / "audit.log"), 4000U);
  EXPECT_LE(std::filesystem::file_size(folder_ / "audit.old.log"), 4000U);
  EXPECT_EQ(lines().back()["from"], "process 199");
  EXPECT_FALSE(lines("audit.old.log").empty());
}

// If a user repeats a call many times, the log only counts the calls, so other users' lines stay in
// the log.
TEST_F(AuditLogTest, NobodyPushesOutWhatHappenedBefore) {
  AuditLog audit(folder_, clock_);
  audit.note({.user = 4002, .pid = 1}, {.call = "create_token", .outcome = "done"});
  constexpr std::uint64_t k_pins = 300'000;
  for (std::uint64_t i = 0; i < k_pins; ++i) {
    audit.note(far_, {.call = "pin", .of = "14", .outcome = "done"});
    clock_.advance(0.0002);
  }
  audit.note(far_, {.call = "cancel", .of = "15", .outcome = "done"});
  clock_.advance(60);
  audit.flush();
  std::uint64_t pins = 0;
  std::uint64_t others = 0;
  for (const auto& line : lines()) {
    if (line["call"] == "pin") pins += line.value("more", 1);
    if (line["call"] != "pin") ++others;
  }
  EXPECT_EQ(pins, k_pins);
  EXPECT_EQ(others, 2U);
  EXPECT_LE(lines().size(), 1020U);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "audit.old.log"));
  // After some time the user's calls are logged again.
  clock_.advance(100);
  audit.note(far_, {.call = "pin", .of = "16", .outcome = "done"});
  EXPECT_EQ(lines().back()["of"], "16");
}

// Users choose names, so a name may have control characters. Such a name must not break a line of
// the log.
TEST_F(AuditLogTest, OddTextsStayInTheirLine) {
  audit_.note({.user = 1, .pid = 1},
              {.call = "submit", .of = "a\n{\"call\":\"stop\"}\x1b[2J\xff\xc3", .outcome = "done"});
  ASSERT_EQ(lines().size(), 1U);
  EXPECT_EQ(lines()[0]["call"], "submit");
}

// If a folder, a pipe or a link is in the log's place, no call fails, and the problem is reported
// once.
TEST_F(AuditLogTest, AFolderAPipeOrALinkInItsPlace) {
  const auto place = folder_ / "audit.log";
  for (const int kind : {0, 1, 2}) {
    if (kind == 0) std::filesystem::create_directory(place);
    if (kind == 1) {
      ASSERT_EQ(::mkfifo(place.c_str(), 0600), 0);
    }
    if (kind == 2) std::filesystem::create_symlink(folder_ / "elsewhere", place);
    AuditLog audit(folder_, clock_);
    ::testing::internal::CaptureStderr();
    logging::log_to_stderr("test", false);
    audit.note({.user = 1}, {.call = "submit", .outcome = "done"});
    audit.note({.user = 1}, {.call = "submit", .outcome = "done"});
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_THAT(said, HasSubstr("can't write")) << kind;
    EXPECT_EQ(said.find("can't write"), said.rfind("can't write")) << kind;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "elsewhere"));
    std::filesystem::remove(place);
    audit.note({.user = 1}, {.call = "cancel", .outcome = "done"});
    EXPECT_EQ(lines().front()["times"], 2);
    std::filesystem::remove(place);
  }
}

}  // namespace
}  // namespace sleight::daemon
