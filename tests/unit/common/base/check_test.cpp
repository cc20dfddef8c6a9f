#include "common/base/check.h"

#include <gtest/gtest.h>

#include <csignal>
#include <string>

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
  // Goal: a bug report can be written from the message alone. Method: each macro with operands
  // that fail it; the process ends by SIGABRT, in release builds too.
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
  // Goal: operands of any type compile and print as well as they can. Method: a string, an id, and
  // a struct that nothing can print.
  EXPECT_DEATH(CHECK_EQ(std::string("left"), std::string("right")), "\\(left against right\\)");
  EXPECT_DEATH(CHECK_EQ(ChainId{7}, ChainId{8}), "\\(7 against 8\\)");
  EXPECT_DEATH(CHECK_EQ(Unprintable{1}, Unprintable{2}), "\\(\\? against \\?\\)");
}

TEST(Check, EvaluatesEachOperandOnce) {
  // Goal: a check that holds changes nothing and costs its operands once. Method: count calls.
  int calls = 0;
  const auto next = [&] { return ++calls; };
  CHECK_EQ(next(), 1);
  CHECK_LT(1, next());
  CHECK(next() == 3);
  EXPECT_EQ(calls, 3);
}

TEST(Check, StandsWhereAStatementStands) {
  // Goal: a macro is one statement. Method: branches without braces; the untaken check would fail.
  const bool yes = true;
  if (yes)
    CHECK_EQ(1, 1);
  else
    CHECK_EQ(1, 2);
}

}  // namespace
}  // namespace sleight::base
