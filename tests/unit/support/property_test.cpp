// Checks which cases a property test runs, and that the command printed after a failure repeats the
// failure. Tests whose names begin with DISABLED_ fail on purpose. The other tests run them by
// starting this program again.
#include "tests/support/property.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "tests/support/facts.h"
#include "tests/support/failures.h"

namespace sleight::property {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Prints a case number, which the tests below find in the output.
void say(std::uint64_t number) {
  fmt::print("<{}>\n", number);
  std::fflush(stdout);  // If a CHECK ends the process, the buffer is lost.
}

TEST(Planted, DISABLED_Check) {
  // Goal: provide a test whose case 7 of nine ends the process.
  for (const std::uint64_t n : cases(9)) {
    say(n);
    CHECK(n != 7);
  }
}

TEST(Planted, DISABLED_Exception) {
  // Goal: provide a test whose case 7 of nine leaves the loop by an exception.
  for (const std::uint64_t n : cases(9)) {
    say(n);
    if (n == 7) throw std::runtime_error("seven");
  }
}

TEST(Planted, DISABLED_Expectation) {
  // Goal: provide a test whose case 7 of nine fails twice.
  for (const std::uint64_t n : cases(9)) {
    say(n);
    EXPECT_NE(n, 7);
    EXPECT_NE(n, 7) << "again";
  }
}

TEST(Planted, DISABLED_ExpectationOfAnotherThread) {
  // Goal: provide a test whose case 7 of nine fails in another thread.
  for (const std::uint64_t n : cases(9)) {
    say(n);
    std::thread([n] { EXPECT_NE(n, 7); }).join();
  }
}

TEST(Planted, DISABLED_LongRun) {
  // Goal: provide a test that fails in case 7, which only long runs have. A long run has nine
  // cases, other runs have six.
  for (const std::uint64_t n : seeds(long_run() ? 9 : 6)) {
    say(n);
    EXPECT_NE(n, 7);
  }
}

TEST(Planted, DISABLED_OutsideCases) {
  // Goal: provide a test that fails after its loop of cases.
  for (const std::uint64_t n : cases(9))
    say(n);
  ADD_FAILURE();
}

TEST(Planted, DISABLED_NoFailure) {
  // Goal: provide a test that passes and shows what runs. Method: print a number for each case and
  // each seed, and 1000 if all cases run.
  for (const std::uint64_t n : cases(9))
    say(n);
  for (const std::uint64_t n : seeds(3))
    say(100 + n);
  if (all_cases()) say(1000);
}

TEST(Planted, DISABLED_ManyCases) {
  // Goal: provide a test of a hundred cases, of which some builds run only a part.
  for (const std::uint64_t n : cases(100))
    say(n);
  if (all_cases()) say(1000);
}

TEST(Planted, DISABLED_InTurn) {
  // Goal: provide a test whose case 7 fails only if case 6 ran before.
  std::uint64_t before = 0;
  for (const std::uint64_t n : in_turn(9)) {
    say(n);
    EXPECT_NE(before, 6);
    before = n;
  }
}

class PlantedValues : public ::testing::TestWithParam<int> {};

TEST_P(PlantedValues, DISABLED_Expectation) {
  // Goal: provide a parametrised test, whose name has slashes. For one of three values, case 7
  // fails.
  for (const std::uint64_t n : cases(9)) {
    say(n);
    EXPECT_FALSE(n == 7 && GetParam() == 3);
  }
}

INSTANTIATE_TEST_SUITE_P(Odd, PlantedValues, ::testing::Values(1, 3, 5));

/// A shell command's output on both streams, and its exit status (0: success).
struct Ended {
  std::string output;
  int status = 0;

  std::vector<std::uint64_t> cases() const {
    std::vector<std::uint64_t> found;
    for (std::size_t at = output.find("\n<"); at != std::string::npos; at = output.find("\n<", at))
      found.push_back(std::strtoull(output.c_str() + (at += 2), nullptr, 10));
    return found;
  }
  /// Returns the command that the first failure printed.
  std::string command() const {
    constexpr std::string_view k_said = "\nto see it again: ";
    const std::size_t at = output.find(k_said);
    if (at == std::string::npos) return "";
    const std::size_t begin = at + k_said.size();
    return output.substr(begin, output.find('\n', begin) - begin);
  }
  std::size_t commands() const {
    std::size_t count = 0;
    for (std::size_t at = output.find("see it again"); at != std::string::npos;
         at = output.find("see it again", at + 1))
      ++count;
    return count;
  }
};

std::string whole_path() {
  return std::filesystem::read_symlink("/proc/self/exe").string();
}

Ended ended(const std::string& command) {
  // Run DISABLED_ tests. Unset the variables that request long and full runs, so that the command
  // doesn't inherit them.
  std::FILE* const pipe =
      popen(fmt::format(
                "unset SLEIGHT_SOAK SLEIGHT_ALL; export GTEST_ALSO_RUN_DISABLED_TESTS=1; ({}) 2>&1",
                command)
                .c_str(),
            "r");
  Ended of;
  std::array<char, 4096> part{};
  for (std::size_t size = 0; (size = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    of.output.append(part.data(), size);
  of.status = pclose(pipe);
  return of;
}

Ended ended_test(const std::string& environment, const std::string& test) {
  return ended(fmt::format("{} {} --gtest_filter={}", environment, whole_path(), test));
}

/// Makes a printed command work from the current folder.
std::string from_here(std::string command) {
  const std::string in_project = path_in_project(whole_path());
  const std::size_t at = command.find(in_project);
  return at == std::string::npos ? "" : command.replace(at, in_project.size(), whole_path());
}

TEST(Property, AFailurePrintsTheCommandThatRepeatsItsCase) {
  // Goal: however a case fails, the output has one command that runs only this case, and the case
  // fails again. Method: run the tests above that fail in case 7, then run the printed commands.
  for (const char* const test :
       {"Planted.DISABLED_Check", "Planted.DISABLED_Exception", "Planted.DISABLED_Expectation",
        "Planted.DISABLED_ExpectationOfAnotherThread",
        "Odd/PlantedValues.DISABLED_Expectation/1"}) {
    SCOPED_TRACE(test);
    const Ended first = ended_test("", test);
    EXPECT_NE(first.status, 0);
    EXPECT_THAT(first.cases(), ::testing::SizeIs(::testing::Ge(8U)));
    EXPECT_EQ(first.commands(), 1U) << first.output;
    EXPECT_EQ(first.command(), fmt::format("SLEIGHT_CASE=7 {} --gtest_filter={}",
                                           path_in_project(whole_path()), test));
    const Ended again = ended(from_here(first.command()));
    EXPECT_NE(again.status, 0);
    EXPECT_THAT(again.cases(), ElementsAre(7));
    EXPECT_EQ(again.command(), first.command()) << again.output;
  }
}

TEST(Property, ACaseOfALongRunIsRepeatedAsALongRuns) {
  // Goal: the printed command repeats a case that only long runs have.
  const Ended longer = ended_test("SLEIGHT_SOAK=1", "Planted.DISABLED_LongRun");
  EXPECT_THAT(longer.cases(), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(longer.command(),
            fmt::format("SLEIGHT_SOAK=1 SLEIGHT_CASE=7 {} --gtest_filter=Planted.DISABLED_LongRun",
                        path_in_project(whole_path())));
  EXPECT_THAT(ended(from_here(longer.command())).cases(), ElementsAre(7));
  EXPECT_EQ(ended_test("", "Planted.DISABLED_LongRun").status, 0);
}

TEST(Property, ACaseThatNeedsOthersIsRepeatedAfterThem) {
  // Goal: if a case depends on earlier cases, the printed command runs these cases too, so the case
  // fails again.
  const Ended first = ended_test("", "Planted.DISABLED_InTurn");
  EXPECT_THAT(first.cases(), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
  const Ended again = ended(from_here(first.command()));
  EXPECT_THAT(again.cases(), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_EQ(again.command(), first.command());
  EXPECT_NE(again.status, 0);
}

TEST(Property, AFailureOutsideCasesNamesItsTest) {
  // Goal: if a failure belongs to no case, the printed command repeats the whole test.
  const Ended of = ended_test("", "Planted.DISABLED_OutsideCases");
  EXPECT_EQ(of.command(), fmt::format("{} --gtest_filter=Planted.DISABLED_OutsideCases",
                                      path_in_project(whole_path())));
}

TEST(Property, OneCaseIsThatOfEachLoopThatHasIt) {
  // Goal: SLEIGHT_CASE selects one case and skips expectations about all cases. Method: run a test
  // with two loops. Select a number that occurs in both loops, then a number that occurs in only
  // one loop.
  const std::string test = "Planted.DISABLED_NoFailure";
  EXPECT_THAT(ended_test("SLEIGHT_SOAK=1", test).cases(),
              ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 101, 102, 103, 1000));
  EXPECT_THAT(ended_test("SLEIGHT_CASE=3", test).cases(), ElementsAre(3, 103));
  EXPECT_THAT(ended_test("SLEIGHT_CASE=0", test).cases(), ElementsAre(0));
  EXPECT_EQ(ended_test("SLEIGHT_CASE=3", test).status, 0);
}

TEST(Property, SanitizersRunTheFirstQuarter) {
  // Goal: with sanitizers, a loop runs the first quarter of its cases. SLEIGHT_CASE can still
  // select any case, and long runs run all cases. Builds without sanitizers run all cases.
  const std::string test = "Planted.DISABLED_ManyCases";
  const std::vector<std::uint64_t> whole = ended_test("SLEIGHT_SOAK=1", test).cases();
  ASSERT_EQ(whole.size(), 101U);
  EXPECT_EQ(whole.front(), 0U);
  EXPECT_EQ(whole[99], 99U);
  EXPECT_EQ(whole.back(), 1000U);
#ifdef SLEIGHT_SANITIZED
  const std::vector<std::uint64_t> expected(whole.begin(), whole.begin() + 25);
#else
  const std::vector<std::uint64_t>& expected = whole;
#endif
  EXPECT_EQ(ended_test("", test).cases(), expected);
  EXPECT_THAT(ended_test("SLEIGHT_CASE=99", test).cases(), ElementsAre(99));
}

TEST(Property, ACaseThatNoTestHasIsAnError) {
  // Goal: if SLEIGHT_CASE selects no case, the test fails, so a wrong number can't suggest that a
  // failure is fixed. Method: set SLEIGHT_CASE to numbers that no case has, and to texts that are
  // not numbers.
  for (const char* const wrong : {"9", "", "x", "7x", "-1", "18446744073709551616"}) {
    const Ended of =
        ended_test(fmt::format("SLEIGHT_CASE={}", wrong), "Planted.DISABLED_NoFailure");
    EXPECT_NE(of.status, 0) << wrong;
    EXPECT_THAT(of.output, HasSubstr("SLEIGHT_CASE")) << wrong;
    EXPECT_TRUE(of.cases().empty()) << wrong;
  }
}

TEST(Property, AFailureCanBeAskedFor) {
  // Goal: SLEIGHT_FAIL_CASE makes a test that passes show the output of a failure.
  const Ended of = ended_test("SLEIGHT_FAIL_CASE=5", "Planted.DISABLED_NoFailure");
  EXPECT_NE(of.status, 0);
  EXPECT_EQ(of.command(), fmt::format("SLEIGHT_CASE=5 {} --gtest_filter=Planted.DISABLED_NoFailure",
                                      path_in_project(whole_path())));
  // The program reports a case number that no test has.
  const Ended none = ended_test("SLEIGHT_FAIL_CASE=200", "Planted.DISABLED_NoFailure");
  EXPECT_NE(none.status, 0);
  EXPECT_THAT(none.output, tests::HasFacts("SLEIGHT_FAIL_CASE: |no test|200"));
  EXPECT_THAT(none.output, Not(HasSubstr("to see it again")));
}

TEST(Property, ProgramsAreNamedAsInTheProject) {
  // Goal: a command's path begins at the project's folder. The path of a program outside of the
  // project stays whole.
  EXPECT_EQ(path_in_project("/a/build/b/build/release/tests/t"), "build/release/tests/t");
  EXPECT_EQ(path_in_project("/opt/t"), "/opt/t");
}

}  // namespace
}  // namespace sleight::property
