#include "worker/sampling/stage_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "common/random/discrete_distributions.h"

namespace sleight::sampling {
namespace {

/// A lock of six digits below ten. A digit is promising if it differs from the last digit; nothing
/// is promising after a 7. A solution begins with an even digit.
struct Lock {
  using Prefix = std::vector<std::uint64_t>;
  std::uint32_t digits = 6;
  bool has_dead_ends = true;
  bool has_a_solution = true;
  std::multimap<std::uint32_t, double>* misses = nullptr;  ///< By stage.

  std::uint32_t stages() const { return digits; }
  static SearchLimits limits() { return {}; }
  Prefix start(random::Stream&) const { return {}; }
  std::optional<Prefix> attempt(const Prefix& prefix, std::uint32_t stage, SearchEffort& effort,
                                random::Stream& stream) const {
    EXPECT_EQ(prefix.size(), stage);
    ++effort.simulations;
    const std::uint64_t digit = random::UniformInteger{.count = 10}.draw(stream);
    if (!prefix.empty() && ((has_dead_ends && prefix.back() == 7) || digit == prefix.back())) {
      effort.misses(stage, 0, static_cast<double>(digit));
      if (misses) misses->emplace(stage, digit);
      return std::nullopt;
    }
    Prefix longer = prefix;
    longer.push_back(digit);
    return longer;
  }
  bool is_solution(const Prefix& prefix) const {
    EXPECT_EQ(prefix.size(), digits);
    return has_a_solution && prefix.front() % 2 == 0;
  }
};
static_assert(StageBuilder<Lock>);

random::Stream stream_of(std::uint64_t number) {
  return random::Stream({.seed = 17, .purpose = random::Purpose::search}, number);
}

TEST(StageSearch, FindsSolutionsBeyondDeadEnds) {
  // Goal: search() finds solutions. If a stage has no promising successors, search() takes the
  // stage back. Method: search a lock with dead ends 500 times. Every stage of a find must be
  // promising.
  const Lock lock;
  SearchEffort effort;
  int found = 0;
  for (std::uint64_t number = 0; number < 500; ++number) {
    random::Stream stream = stream_of(number);
    const auto digits =
        search(lock, {.tries_of_stage = 20, .turns_per_stage = 100}, stream, effort);
    if (!digits) continue;
    ++found;
    EXPECT_EQ((*digits)[0] % 2, 0U);
    for (std::size_t i = 0; i + 1 < digits->size(); ++i) {
      EXPECT_NE((*digits)[i], 7U);
      EXPECT_NE((*digits)[i], (*digits)[i + 1]);
    }
  }
  EXPECT_GT(found, 200);
  EXPECT_GT(effort.steps_back, 100U);
  EXPECT_EQ(effort.simulations, effort.tries);
}

TEST(StageSearch, SpendsItsTriesAndGivesUp) {
  // Goal: a search stops at its limits on tries and turns. Method: search a lock without a
  // solution. Then search with a limit of zero turns, and with a limit of zero tries.
  SearchEffort effort;
  random::Stream stream = stream_of(0);
  const Lock unsolvable{.has_dead_ends = false, .has_a_solution = false};
  EXPECT_FALSE(search(unsolvable, {.tries_of_stage = 50, .turns_per_stage = 10}, stream, effort));
  EXPECT_LE(effort.tries, 60U);
  EXPECT_GT(effort.steps_back, 10U);
  SearchEffort none;
  EXPECT_FALSE(search(Lock{}, {.tries_of_stage = 50, .turns_per_stage = 0}, stream, none));
  EXPECT_EQ(none.tries, 0U);
  SearchEffort stuck;
  EXPECT_FALSE(search(Lock{}, {.tries_of_stage = 0, .turns_per_stage = 10}, stream, stuck));
  EXPECT_EQ(stuck.tries, 0U);
}

TEST(StageSearch, KeepsTheNearestMissOfItsFurthestStage) {
  // Goal: a search that gives up knows the nearest miss of the stage after its furthest one. Of two
  // kinds, the lower one is nearer. Method: compare with a list of all misses.
  int known = 0;
  for (std::uint64_t number = 0; number < 200; ++number) {
    std::multimap<std::uint32_t, double> misses;
    SearchEffort effort;
    random::Stream stream = stream_of(number);
    search(Lock{.misses = &misses}, {.tries_of_stage = 4, .turns_per_stage = 1}, stream, effort);
    std::optional<Miss> nearest;
    for (const auto& [stage, amount] : misses) {
      if (stage == effort.furthest && (!nearest || amount < nearest->amount))
        nearest = Miss{.kind = 0, .amount = amount};
    }
    EXPECT_EQ(effort.nearest, nearest);
    known += nearest ? 1 : 0;
  }
  EXPECT_GT(known, 20);
  SearchEffort effort;
  for (const Miss& miss : {Miss{2, NAN}, Miss{1, 5}, Miss{2, 3}, Miss{0, INFINITY}})
    effort.misses(0, miss.kind, miss.amount);
  EXPECT_EQ(effort.nearest, (Miss{.kind = 1, .amount = 5}));
}

}  // namespace
}  // namespace sleight::sampling
