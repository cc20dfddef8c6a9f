// Goal: the distance of two animations counts each body's places in its own diameters. Method:
// compare with distances that are calculated by hand.
#include "worker/worlds/readers/places_likeness.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sleight::worlds {
namespace {

using math::Vec3;

TEST(PlacesLikeness, EachBodyIsMeasuredByItsDiameter) {
  const PlacesLikeness likeness{.diameters_m = {0.5, 4}, .step = 10};
  /// Two bodies that stay `apart_m` from x = 0. Body 1 starts at tick `start`.
  const auto numbers = [&](double events, Vec3 apart_m, int start, int end) {
    return likeness.numbers(events, {end}, [=](std::uint32_t body, physics::Tick tick) {
      if (body == 1 && tick.value < start) return Vec3(Vec3::Constant(std::nan("")));
      return Vec3(apart_m[body], 0, 0);
    });
  };
  const auto still = numbers(0, {0, 0, 0}, 0, 25);
  ASSERT_EQ(still.size(), 1U + 4 * 6);  // ticks 0, 10, 20 and 25
  const auto expect_distance = [&](const std::vector<double>& other, double expected) {
    for (const auto& [a, b] : {std::pair(still, other), std::pair(other, still)}) {
      EXPECT_EQ(likeness.distance(a, b), expected);
      EXPECT_EQ(likeness.distance(a, b, expected), expected);
      const double less = std::nextafter(expected, -1);
      EXPECT_GT(likeness.distance(a, b, less), less);
    }
  };
  expect_distance(still, 0);
  expect_distance(numbers(0, {0.25, 0, 0}, 0, 25), 0.5);
  expect_distance(numbers(0, {0.25, 1, 0}, 0, 25), 0.5);
  expect_distance(numbers(0, {0.25, 3, 0}, 0, 25), 0.75);
  expect_distance(numbers(4, {0.25, 3, 0}, 0, 25), 1.75);
  // Body 1 counts only if it has started. A longer animation is compared with the last places.
  expect_distance(numbers(0, {0.25, 3, 0}, 40, 25), 0.5);
  expect_distance(numbers(0, {0.25, 3, 0}, 40, 45), 0.75);
}

}  // namespace
}  // namespace sleight::worlds
