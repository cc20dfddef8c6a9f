// Goal: whatever a guarded child does, the parent goes on and knows what happened.
#include "common/archive/hdf5/guarded.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <iostream>
#include <vector>

#include "common/base/error.h"

namespace sleight::archive::hdf5 {
namespace {

using ::testing::HasSubstr;

void expect_refusal(const GuardLimits& limits, const std::function<int()>& work,
                    base::ExitCode code, const std::string& reason) {
  try {
    guarded("some.h5", limits, work);
    FAIL() << reason;
  } catch (const base::Error& error) {
    EXPECT_EQ(static_cast<int>(error.exit_code()), static_cast<int>(code)) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(reason));
  }
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child was left behind";
}

TEST(Guarded, ReturnsTheExitCode) {
  EXPECT_EQ(guarded("some.h5", {}, [] { return 0; }), 0);
  EXPECT_EQ(guarded("some.h5", {}, [] { return 77; }), 77);
}

TEST(Guarded, PassesErrorsOn) {
  expect_refusal(
      {}, []() -> int { throw base::Error(base::ExitCode::usage, "what I mean"); },
      base::ExitCode::usage, "what I mean");
  expect_refusal(
      {}, []() -> int { throw std::runtime_error("unexpected"); }, base::ExitCode::bug,
      "unexpected");
}

TEST(Guarded, ReportsCrashes) {
  expect_refusal(
      {},
      []() -> int {
        ::raise(SIGKILL);
        return 0;
      },
      base::ExitCode::bad_archive, "some.h5: the process that read it crashed (Killed)");
  expect_refusal(
      {}, []() -> int { ::_exit(3); }, base::ExitCode::bad_archive, "ended early with code 3");
  expect_refusal(
      {},
      []() -> int {
        ::raise(SIGTERM);
        return 0;
      },
      base::ExitCode::interrupted, "interrupted");
}

TEST(Guarded, EndsChildrenThatHang) {
  const auto start = std::chrono::steady_clock::now();
  expect_refusal(
      {.timeout_s = 0.3},
      []() -> int {
        while (true)
          ::pause();
      },
      base::ExitCode::bad_archive, "more than 0.3 s");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST(Guarded, EndsChildrenThatSpin) {
  expect_refusal(
      {.cpu_s = 1, .timeout_s = 60},
      []() -> int {
        std::atomic<std::uint64_t> turns{0};
        while (true)
          ++turns;
      },
      base::ExitCode::bad_archive, "1 s");
}

#ifndef SLEIGHT_SANITIZED
TEST(Guarded, LimitsMemory) {
  expect_refusal(
      {.address_space_bytes = std::uint64_t{1} << 30},
      []() -> int { return static_cast<int>(std::vector<char>(3u << 30).size() % 2); },
      base::ExitCode::bad_archive, "bytes of memory");
}
#endif

TEST(Guarded, TheChildsOutputIsOurs) {
  ::testing::internal::CaptureStdout();
  std::cout << "before, ";
  std::printf("and ");
  guarded("some.h5", {}, [] {
    std::cout << "within";
    return 0;
  });
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "before, and within");
}

}  // namespace
}  // namespace sleight::archive::hdf5
