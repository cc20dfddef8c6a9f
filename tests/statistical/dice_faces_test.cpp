// Tests that dice are fair: without goals, each face comes up with probability 1/6.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/math/rotation.h"
#include "tests/statistical/support/chi_square.h"
#include "tests/support/property.h"
#include "worker/worlds/dice/dice.h"

namespace sleight::statistical::dice_faces_test {

using worlds::dice::Dice;
using worlds::dice::DieView;
using worlds::dice::End;
using worlds::dice::Parameters;

constexpr std::uint64_t k_seed = 141421;
constexpr double k_significance = 1e-4;

std::size_t side_up(const DieView& die) {
  const math::Mat3 axes = math::matrix_of(die.orientation);
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::fabs(axes(2, k)) > std::fabs(axes(2, axis))) axis = k;
  }
  return 2 * static_cast<std::size_t>(axis) + (axes(2, axis) > 0 ? 1U : 0U);
}

TEST(DiceFaces, ComeUpOnceInSixThrows) {
  // Goal: the simulator prefers no side of a cube. Method: simulate 3,000 throws from the prior
  // (60,000 with SLEIGHT_SOAK=1), and count which side of the resting die is up. A chi-square test
  // compares the counts with 1/6 for each side. By chance, the test fails for one of 10,000 seeds.
  const std::uint64_t throws = property::long_run() ? 60'000 : 3'000;
  const Dice world(Parameters{});
  std::vector<double> counts(6, 0.0);
  for (std::uint64_t i = 0; i < throws; ++i) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::prior}, i);
    const auto outcome = world.simulate(world.draw_prior(stream));
    ASSERT_EQ(outcome.end, End::settled) << "throw " << i << " of seed " << k_seed;
    ++counts[side_up(outcome.at_end[0])];
  }
  const double p = chi_square_p(counts, std::vector<double>(6, 1.0 / 6.0));
  RecordProperty("p", std::to_string(p));
  std::printf("sides of %llu throws: %.0f %.0f %.0f %.0f %.0f %.0f, p = %.3g\n",
              static_cast<unsigned long long>(throws), counts[0], counts[1], counts[2], counts[3],
              counts[4], counts[5], p);
  EXPECT_GT(p, k_significance);
}

}  // namespace sleight::statistical::dice_faces_test
