#include "common/base/check.h"

#include <gtest/gtest.h>

#include <csignal>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "common/base/ids.h"

namespace sleight::base {
namespace {

struct Unprintable {
  int value = 0;
  friend bool operator==(const Unprintable&, const Unprintable&) = default;
};

class CheckDeathTest : public ::testing::Test {
 protected:
  CheckDeathTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(CheckDeathTest, PrintsPlaceConditionAndBothOperands) {
  // Goal: the message of a failed check names the file, the line, the condition and both operands.
  // The process ends with SIGABRT, in release builds too.
  const int three = 3;
  const int four = 4;
  EXPECT_DEATH(CHECK(three == four),
               "check_test\\.cpp:[0-9]+: check failed: three == four \\(false\\)");
  EXPECT_DEATH(CHECK_EQ(three, four), "check_test\\.cpp:[0-9]+: .*three == four \\(3 against 4\\)");
  EXPECT_DEATH(CHECK_NE(three, 3), "three != 3 \\(3 against 3\\)");
  EXPECT_DEATH(CHECK_LT(four, three), "four < three \\(4 against 3\\)");
  EXPECT_DEATH(CHECK_LE(four, three), "four <= three \\(4 against 3\\)");
  EXPECT_DEATH(CHECK_GT(three, four), "three > four \\(3 against 4\\)");
  EXPECT_DEATH(CHECK_GE(three, four), "three >= four \\(3 against 4\\)");
  EXPECT_EXIT(CHECK(three == four), ::testing::KilledBySignal(SIGABRT), "");
}

TEST_F(CheckDeathTest, PrintsTextIdsAndWhatHasNoFormat) {
  // Goal: operands of any type can be checked. An operand that can't be printed appears as a
  // question mark.
  EXPECT_DEATH(CHECK_EQ(std::string("left"), std::string("right")), "\\(left against right\\)");
  EXPECT_DEATH(CHECK_EQ(ChainId{7}, ChainId{8}), "\\(7 against 8\\)");
  EXPECT_DEATH(CHECK_EQ(Unprintable{1}, Unprintable{2}), "\\(\\? against \\?\\)");
}

TEST_F(CheckDeathTest, PrintsHowToRepeatTheRun) {
  // Goal: if a check fails in any thread, the notes on how to repeat the run are printed in order.
  // Method: add two notes, then fail a check in the main thread and in another thread.
  const auto note = [] {
    add_repeat_note("to repeat: sleight direct hi.toml");
    add_repeat_note("seed 7");
  };
  constexpr const char* k_expected =
      "check failed: 1 == 2 \\(1 against 2\\)\nto repeat: sleight direct hi.toml\nseed 7\n";
  EXPECT_DEATH(
      {
        note();
        CHECK_EQ(1, 2);
      },
      k_expected);
  EXPECT_DEATH(
      {
        note();
        std::thread([] { CHECK_EQ(1, 2); }).join();
      },
      k_expected);
}

TEST_F(CheckDeathTest, PrintsExceptionsThatNobodyCatches) {
  // Goal: an exception that nobody catches is reported as a bug, with the notes on how to repeat
  // the run. Lack of memory is reported as a failure of the environment.
  const auto throw_in_thread = [](const auto& exception) {
    report_uncaught_exceptions();
    add_repeat_note("seed 7");
    std::thread([&] { throw exception; }).join();
  };
  EXPECT_DEATH(throw_in_thread(std::runtime_error("too much")), "terminated: too much\nseed 7\n");
  EXPECT_DEATH(throw_in_thread(3), "terminated: [^\n]*unknown type\nseed 7\n");
  EXPECT_EXIT(throw_in_thread(3), ::testing::KilledBySignal(SIGABRT), "");
  EXPECT_EXIT(throw_in_thread(std::bad_alloc()), ::testing::ExitedWithCode(5),
              "^too little memory[^\n]*\n$");
}

TEST(RepeatNotes, AreKeptInOrderFromAllThreads) {
  // Goal: if several threads add notes at the same time, all notes are kept. The notes of one
  // thread stay in order.
  const std::string before = repeat_notes();
  std::vector<std::thread> threads;
  for (const char name : {'a', 'b', 'c'}) {
    threads.emplace_back([name] {
      for (int i = 0; i < 100; ++i)
        add_repeat_note(fmt::format("{}{}", name, i));
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  const std::string notes = repeat_notes();
  EXPECT_TRUE(notes.starts_with(before));
  for (const char name : {'a', 'b', 'c'}) {
    std::size_t place = 0;
    for (int i = 0; i < 100; ++i) {
      place = notes.find(fmt::format("{}{}\n", name, i), place);
      ASSERT_NE(place, std::string::npos) << name << i;
    }
  }
}

TEST(CommandLine, IsWhatAShellReadsBack) {
  // Goal: a printed command line can be pasted into a shell, even if its arguments contain spaces,
  // quotes or dollar signs.
  const char* const arguments[] = {"sleight", "direct", "my request.toml", "-o", "a'b.h5",
                                   "",        "$x"};
  EXPECT_EQ(command_line(7, arguments),
            R"(sleight direct 'my request.toml' -o 'a'\''b.h5' '' '$x')");
}

TEST(Check, EvaluatesEachOperandOnce) {
  // Goal: if a check holds, it evaluates each operand once.
  int calls = 0;
  const auto next = [&] { return ++calls; };
  CHECK_EQ(next(), 1);
  CHECK_LT(1, next());
  CHECK(next() == 3);
  EXPECT_EQ(calls, 3);
}

TEST(Check, StandsWhereAStatementStands) {
  // Goal: a check macro is a single statement. Method: use checks as both branches of an `if` that
  // has no braces.
  const bool yes = true;
  if (yes)
    CHECK_EQ(1, 1);
  else
    CHECK_EQ(1, 2);
}

}  // namespace
}  // namespace sleight::base
