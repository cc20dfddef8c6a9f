// Compares overlap() on periodic axes with exact arithmetic on the boxes' periodic images.
#include "worker/physics/broad_phase/periodic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/worker/physics/broad_phase/scenes.h"

namespace sleight::physics {
namespace {

// Oracle: the least distance from an image of one interval to an image of the other. The axis has
// the period L. A negative value is minus the depth of the overlap. If L has few bits, the result
// is exact: all numbers are multiples of 2^-40 below 2^20, so they fit the 64 bits of a long
// double.
long double gap_of_images(const Box& a, const Box& b, std::size_t axis, long double period) {
  const long double here = (static_cast<long double>(a.low_m[axis]) - b.low_m[axis]) / period;
  long double least = std::numeric_limits<long double>::infinity();
  const auto width_a = static_cast<long double>(a.high_m[axis]) - a.low_m[axis];
  const auto width_b = static_cast<long double>(b.high_m[axis]) - b.low_m[axis];
  const auto around = std::ceil((width_a + width_b) / period) + 1;
  for (long double image = std::floor(here) - around; image <= std::floor(here) + around + 1;
       ++image) {
    const long double low = b.low_m[axis] + image * period;
    const long double high = b.high_m[axis] + image * period;
    least = std::min(least, std::max(low - a.high_m[axis], a.low_m[axis] - high));
  }
  return least;
}

/// Returns a multiple of 2^-20, so that sums with periods are exact in the oracle.
float coordinate(Dice& dice, double most) {
  return static_cast<float>(std::round(dice.between(-most, most) * 0x1p20) * 0x1p-20);
}

TEST(Periodic, NeverMissesAnImageAndHardlyInventsOne) {
  // Goal: on periodic axes, overlap() misses no overlap. If overlap() accepts two boxes, their gap
  // is at most 2^-29 of a period. Method: compare overlap() with the exact gap between images of
  // random intervals. The intervals are up to a thousand periods from the origin. The ends of some
  // intervals are equal, or differ only in their last bits.
  Dice dice(1);
  int overlaps = 0;
  int near_misses = 0;
  for (const double length : {1.0, 0.75, 5.0, 10.0, 1000.0 / 8}) {
    const Periods periods({length, 0, 0});
    for (int i = 0; i < 100000; ++i) {
      Box a;
      Box b;
      a.low_m[0] = coordinate(dice, length * (dice.once_in(2) ? 1 : 1000));
      b.low_m[0] = coordinate(dice, length * (dice.once_in(2) ? 1 : 1000));
      a.high_m[0] = a.low_m[0] + static_cast<float>(dice.between(0, length / 2));
      b.high_m[0] = b.low_m[0] + (dice.once_in(3) ? 0 : static_cast<float>(length / 4));
      if (dice.once_in(2)) {
        // Put b's low corner at an image of a's high corner. Sometimes shift b's low corner by a
        // few last bits.
        const double image = length * (static_cast<double>(dice.below(9)) - 4);
        b.low_m[0] = static_cast<float>(double{a.high_m[0]} + image);
        for (std::uint32_t nudges = dice.below(3); nudges > 0; --nudges)
          b.low_m[0] = std::nextafter(b.low_m[0], dice.once_in(2) ? 1e30F : -1e30F);
        b.high_m[0] = std::max(b.high_m[0], b.low_m[0]);
      }
      const long double gap = gap_of_images(a, b, 0, length);
      const bool found = overlap(a, b, periods);
      EXPECT_EQ(found, overlap(b, a, periods));
      if (gap <= 0) {
        ++overlaps;
        ASSERT_TRUE(found) << "missed: " << a.low_m[0] << " to " << a.high_m[0] << " and "
                           << b.low_m[0] << " to " << b.high_m[0] << ", period " << length;
      } else if (gap > length * 0x1p-29) {
        ASSERT_FALSE(found) << "invented: " << a.low_m[0] << " to " << a.high_m[0] << " and "
                            << b.low_m[0] << " to " << b.high_m[0] << ", period " << length;
      } else {
        ++near_misses;
      }
    }
  }
  EXPECT_GT(overlaps, 100000);
  EXPECT_GT(near_misses, 0);
}

TEST(Periodic, EqualsFloatsOnOtherAxes) {
  // Goal: without periods, the codes of two boxes overlap exactly if the boxes overlap. Method:
  // compare overlap() of codes with overlap() of boxes for random pairs. Corners are special floats
  // (such as 0, the largest float and infinity) or neighbours of these floats.
  constexpr float k_infinite = std::numeric_limits<float>::infinity();
  std::vector<float> specials;
  for (const float x : {0.0F, 1e-45F, 1e-38F, 0.5F, 1.0F, 1e6F, 3.4028235e38F, k_infinite}) {
    for (const float y : {x, -x}) {
      specials.insert(specials.end(),
                      {y, std::nextafter(y, k_infinite), std::nextafter(y, -k_infinite)});
    }
  }
  const Periods none({0, 0, 0});
  Dice dice(2);
  const auto any = [&] {
    return specials[dice.below(static_cast<std::uint32_t>(specials.size()))];
  };
  const auto any_box = [&] {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis)
      std::tie(box.low_m[axis], box.high_m[axis]) = std::minmax({any(), any()});
    return box;
  };
  int overlaps = 0;
  for (int i = 0; i < 300000; ++i) {
    const Box a = any_box();
    const Box b = any_box();
    ASSERT_EQ(overlap(a, b, none), overlap(a, b));
    overlaps += overlap(a, b) ? 1 : 0;
    bool within = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      within = within && a.low_m[axis] <= b.low_m[axis] && b.high_m[axis] <= a.high_m[axis];
    ASSERT_EQ(holds(none.coded(a), none.coded(b)), within);
  }
  EXPECT_GT(overlaps, 1000);
}

}  // namespace
}  // namespace sleight::physics
