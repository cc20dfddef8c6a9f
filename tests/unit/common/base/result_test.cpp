#include "common/base/result.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <type_traits>

namespace sleight::base {
namespace {

using Number = Result<int, std::string>;

TEST(Result, KeepsSidesApartWhenTypesAreClose) {
  // Goal: a Result that holds an error stays an error, even if the error converts to the value's
  // type.
  struct Reason {
    operator int() const { return 5; }
  };
  const Result<int, Reason> bad{Reason{}};
  EXPECT_FALSE(bad.ok());
}

TEST(ResultDeathTest, ReadingTheOtherSideIsABug) {
  // Goal: if a Result holds an error, reading its value ends the program. If a Result holds a
  // value, reading its error ends the program.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const Number good(7);
  EXPECT_DEATH((void)good.error(), "check failed: .*\\(0 against 1\\)");
  const Number bad(std::string("no number"));
  EXPECT_DEATH((void)bad.value(), "check failed: .*\\(1 against 0\\)");
  EXPECT_DEATH((void)Number(std::string("x")).value(), "check failed: ok\\(\\)");
}

}  // namespace
}  // namespace sleight::base
