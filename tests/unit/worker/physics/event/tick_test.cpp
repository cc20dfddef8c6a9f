// Goal: ticks_before() rounds a time span down to whole ticks and ticks_after() rounds it up, both
// exactly. Method: test spans with known results. Compare the results for random spans with the
// floor and the ceiling of the exact number of ticks. A tick is a power of two, so scaling by it
// doesn't round.
#include "worker/physics/event/tick.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/numbers.h"
#include "tests/unit/worker/physics/event/queue_checks.h"

namespace sleight::physics {
namespace {

TEST(Ticks, of_spans_between_two) {
  EXPECT_EQ(ticks_before(0.5 * k_seconds_per_tick), 0);
  EXPECT_EQ(ticks_after(0.5 * k_seconds_per_tick), 1);
  EXPECT_EQ(ticks_before(-0.5 * k_seconds_per_tick), -1);
  EXPECT_EQ(ticks_after(-0.5 * k_seconds_per_tick), 0);
  EXPECT_EQ(ticks_before(std::nextafter(1.0, 2.0)), TickCount{1} << 30);
  EXPECT_EQ(ticks_after(std::nextafter(1.0, 2.0)), (TickCount{1} << 30) + 1);
  EXPECT_EQ(ticks_before(std::nextafter(1.0, 0.0)), (TickCount{1} << 30) - 1);
  EXPECT_EQ(ticks_after(std::nextafter(1.0, 0.0)), TickCount{1} << 30);
  EXPECT_EQ(ticks_before(std::nextafter(-1.0, 0.0)), -(TickCount{1} << 30));
  EXPECT_EQ(ticks_after(std::nextafter(-1.0, 0.0)), -(TickCount{1} << 30) + 1);
  const double tiniest_s = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(ticks_before(tiniest_s), 0);
  EXPECT_EQ(ticks_after(tiniest_s), 1);
  EXPECT_EQ(ticks_before(-tiniest_s), -1);
  EXPECT_EQ(ticks_after(-tiniest_s), 0);
}

TEST(Ticks, saturate) {
  const double longest_s = seconds(k_tick_max.value);
  for (const double span_s :
       {longest_s, std::nextafter(longest_s, k_infinity), 1e300, k_infinity}) {
    EXPECT_EQ(ticks_before(span_s), k_tick_max.value);
    EXPECT_EQ(ticks_after(span_s), k_tick_max.value);
    EXPECT_EQ(ticks_before(-span_s), -k_tick_max.value);
    EXPECT_EQ(ticks_after(-span_s), -k_tick_max.value);
  }
  // The span is half a tick shorter than the longest span.
  EXPECT_EQ(ticks_before(std::nextafter(longest_s, 0)), k_tick_max.value - 1);
  EXPECT_EQ(ticks_after(std::nextafter(longest_s, 0)), k_tick_max.value);
}

TEST(Ticks, of_random_spans_meet_the_definition) {
  Dice dice(0);
  for (int i = 0; i < 300'000; ++i) {
    const double scaled =
        std::ldexp(static_cast<double>(dice.bits() >> 11), static_cast<int>(dice.below(70)) - 72);
    const double in_ticks = dice.once_in(2) ? scaled : -scaled;
    const double span_s = in_ticks * k_seconds_per_tick;
    ASSERT_EQ(static_cast<double>(ticks_before(span_s)), std::floor(in_ticks)) << in_ticks;
    ASSERT_EQ(static_cast<double>(ticks_after(span_s)), std::ceil(in_ticks)) << in_ticks;
  }
}

}  // namespace
}  // namespace sleight::physics
