// Goal: two holders of a lease may never act at the same time. Method: simulate machines that
// compete for the lease (lease_world.h).
#include <gtest/gtest.h>

#include "tests/support/property.h"
#include "tests/unit/common/store/lease_world.h"

namespace sleight::store {
namespace {

using testing::LeaseStory;
using testing::Mistake;
using testing::simulate_leases;

TEST(LeaseProperty, NeverTwoThatMayAct) {
  // Goal: at most one holder believes that it may act, even if processes pause or die, and even if
  // disk calls fail or take effect late. The lease still passes from holder to holder. Method:
  // simulate a quarter of an hour with many seeds. There are 4 processes on 3 machines. Before and
  // after every step, count the holders that may act.
  const std::uint64_t stories = property::long_run() ? 20'000 : property::of_tier(20, 100);
  LeaseStory all;
  for (const std::uint64_t seed : property::seeds(stories)) {
    const LeaseStory story = simulate_leases(seed);
    EXPECT_EQ(story.violation, std::nullopt) << "seed " << seed;
    all.taken += story.taken;
    all.taken_over += story.taken_over;
    all.refused += story.refused;
    all.lost += story.lost;
  }
  if (!property::all_cases()) return;
  EXPECT_GT(all.taken, property::of_tier(60, 300));
  EXPECT_GT(all.taken_over, property::of_tier(10, 50));
  EXPECT_GT(all.refused, property::of_tier(60, 300));
  EXPECT_GT(all.lost, property::of_tier(4, 20));
}

class LeaseMistake : public ::testing::TestWithParam<Mistake> {};

TEST_P(LeaseMistake, IsCaught) {
  // Goal: the simulation detects a faulty lease protocol. Method: plant one mistake in the
  // protocol. For at least one seed, two holders must act at the same time.
  constexpr std::uint64_t k_seeds_max = 300;
  for (std::uint64_t seed = 1; seed <= k_seeds_max; ++seed) {
    if (simulate_leases(seed, GetParam()).violation) return;
  }
  FAIL() << "not in " << k_seeds_max << " seeds";
}

INSTANTIATE_TEST_SUITE_P(All, LeaseMistake,
                         ::testing::Values(Mistake::breaks_the_lock, Mistake::believes_old_lists,
                                           Mistake::clock_stands_still,
                                           Mistake::clocks_too_different,
                                           Mistake::takes_all_for_dead));

}  // namespace
}  // namespace sleight::store
