// GoogleTest's main(), which also prints the command that repeats each failure (property.h).
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>

#include "tests/support/failures.h"

namespace sleight::property {
namespace {

std::string this_program() {
  return path_in_project(std::filesystem::read_symlink("/proc/self/exe").string());
}

/// The current test as `Suite.Name`. GoogleTest's accessor may block during reports, so the name is
/// copied.
std::string& current_test() {
  static std::string name;
  return name;
}

std::string command() {
  return command_of(this_program(), current_test(), current_case(), asked().long_run);
}

class Printer : public testing::EmptyTestEventListener {
 public:
  void OnTestStart(const testing::TestInfo& test) override {
    set_current_case(std::nullopt);
    current_test() = fmt::format("{}.{}", test.test_suite_name(), test.name());
    told_.clear();
  }
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed() || current_test().empty() || command() == told_) return;
    told_ = command();  // Once for all failures of one case.
    std::printf("to see it again: %s\n", told_.c_str());
    std::fflush(stdout);
  }
  void OnTestEnd(const testing::TestInfo&) override { current_test().clear(); }

 private:
  std::string told_;
};

/// Handles a fatal signal. fmt::format isn't async-signal-safe. The handler may use it because the
/// process ends anyway.
void say_and_die(int signal) {
  if (!current_test().empty()) {
    const std::string line = fmt::format("to see it again: {}\n", command());
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line.data(), line.size());
  }
  std::raise(signal);  // SA_RESETHAND: the system handles the signal once this handler returns.
}

/// Handles fatal signals, except those that a sanitizer handles.
void catch_deaths() {
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGBUS}) {
    struct sigaction before {};
    if (sigaction(signal, nullptr, &before) != 0 || before.sa_handler != SIG_DFL) continue;
    struct sigaction action {};
    action.sa_handler = say_and_die;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(signal, &action, nullptr);
  }
}

int run(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  const auto only = asked().only_case;
  testing::UnitTest::GetInstance()->listeners().Append(new Printer);  // The listeners own it.
  catch_deaths();
  const int result = RUN_ALL_TESTS();
  if (only && !testing::GTEST_FLAG(list_tests) && !only_case_was_met()) {
    std::fprintf(stderr, "SLEIGHT_CASE: no test that ran has a case %llu\n",
                 static_cast<unsigned long long>(*only));
    return 1;
  }
  const auto failing = asked().failing_case;
  if (failing && !testing::GTEST_FLAG(list_tests) && !failing_case_was_met()) {
    std::fprintf(stderr, "SLEIGHT_FAIL_CASE: no test that ran has a case %llu\n",
                 static_cast<unsigned long long>(*failing));
    return 1;
  }
  return result;
}

}  // namespace
}  // namespace sleight::property

int main(int argc, char** argv) {
  try {
    return sleight::property::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
