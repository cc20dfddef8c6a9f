#include "common/base/clock.h"

#include <gtest/gtest.h>

namespace sleight::base {
namespace {

TEST(ManualClock, MovesOnlyWhenItIsMoved) {
  // Goal: tests own the time. Method: read it before and after each move.
  ManualClock clock;
  EXPECT_EQ(clock.now_s(), 0);
  EXPECT_EQ(clock.now_s(), 0);
  clock.advance(1.5);
  clock.advance(0.25);
  EXPECT_EQ(clock.now_s(), 1.75);
}

TEST(SteadyClock, NeverGoesBackAndDoesGoOn) {
  // Goal: differences are times. Method: many readings, until one differs from the first.
  const SteadyClock clock;
  const double first_s = clock.now_s();
  double last_s = first_s;
  while (last_s == first_s) {
    const double now_s = clock.now_s();
    ASSERT_GE(now_s, last_s);
    last_s = now_s;
  }
  EXPECT_GT(last_s, first_s);
}

}  // namespace
}  // namespace sleight::base
