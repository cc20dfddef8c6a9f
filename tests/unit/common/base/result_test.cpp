#include "common/base/result.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <type_traits>

namespace sleight::base {
namespace {

using Number = Result<int, std::string>;

TEST(Result, KeepsSidesApartWhenTypesAreClose) {
  // Goal: a Result doesn't confuse a value with an error of a convertible type. Method: make the
  // error convertible.
  struct Reason {
    operator int() const { return 5; }
  };
  const Result<int, Reason> bad{Reason{}};
  EXPECT_FALSE(bad.ok());
}

TEST(ResultDeathTest, ReadingTheOtherSideIsABug) {
  // Goal: reading the value of an error, or the error of a value, ends the program. Method: try all
  // three accessors.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const Number good(7);
  EXPECT_DEATH((void)good.error(), "check failed: .*\\(0 against 1\\)");
  const Number bad(std::string("no number"));
  EXPECT_DEATH((void)bad.value(), "check failed: .*\\(1 against 0\\)");
  EXPECT_DEATH((void)Number(std::string("x")).value(), "check failed: ok\\(\\)");
}

}  // namespace
}  // namespace sleight::base
