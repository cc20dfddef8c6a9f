#include "worker/sampling/swap_flow.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "worker/sampling/swap.h"

namespace sleight::sampling::swap_flow_test {

constexpr std::uint64_t k_seed = 667430;
constexpr std::uint64_t k_scans = 40;

FlowLevels ladder_of(std::uint32_t levels) {
  FlowLevels ladder{.seed = k_seed,
                    .chain = base::ChainId{2},
                    .levels = levels,
                    .first_level = 0,
                    .inverse_temperatures = {}};
  for (std::uint32_t level = 0; level < levels; ++level)
    ladder.inverse_temperatures.push_back(level / (levels - 1.0));
  return ladder;
}

/// log p_c of a replica's state after a scan. Sometimes -infinity.
double density(std::uint32_t replica, std::uint64_t scan) {
  random::Stream stream({.seed = k_seed,
                         .chain = {},
                         .replica = base::ReplicaId{replica},
                         .purpose = random::Purpose::prior},
                        scan);
  const double u = stream.uniform();
  return u < 0.1 ? -std::numeric_limits<double>::infinity() : -6 * u;
}

/// The replica at each scan and level, if all levels run in step.
using Seating = std::vector<std::vector<std::uint32_t>>;
Seating lockstep(const FlowLevels& ladder) {
  std::vector<std::uint32_t> at(ladder.levels);
  std::iota(at.begin(), at.end(), 0U);
  Seating seating;
  for (std::uint64_t scan = 0; scan < k_scans; ++scan) {
    seating.push_back(at);
    for (std::uint32_t i = scan % 2; i + 1 < ladder.levels; i += 2) {
      const bool swapped =
          swaps({.seed = ladder.seed, .chain = ladder.chain, .level = i, .scan = scan},
                {.hotter = ladder.inverse_temperatures[i],
                 .cooler = ladder.inverse_temperatures[i + 1],
                 .log_constraint_hotter = density(at[i], scan),
                 .log_constraint_cooler = density(at[i + 1], scan)});
      if (swapped) std::swap(at[i], at[i + 1]);
    }
  }
  return seating;
}

std::uint64_t below(random::Stream& stream, std::uint64_t count) {
  return random::UniformInteger{.count = count}.draw(stream);
}

/// Levels that may run now and are not yet at the last scan.
std::vector<std::uint32_t> ready(const SwapFlow& flow) {
  std::vector<std::uint32_t> levels;
  for (std::uint32_t level = 0; level < flow.size(); ++level) {
    if (flow.seat(level).may_run() && flow.seat(level).scan + 1 < k_scans) levels.push_back(level);
  }
  return levels;
}

TEST(SwapFlow, EqualsTheLevelsInStepInAnyOrder) {
  // Goal: levels may run in any order. Replicas move as if all levels ran each scan together.
  // Method: in 200 ladders of 2 to 9 levels, run a random level at each step. Compare each
  // replica's level with a run of all levels in step. In some orders, one level runs four scans
  // ahead of another level.
  std::uint64_t ahead_most = 0;
  for (std::uint64_t index = 0; index < 200; ++index) {
    SCOPED_TRACE(fmt::format("seed {}, case {}", k_seed, index));
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::start}, index);
    const FlowLevels ladder = ladder_of(static_cast<std::uint32_t>(2 + below(stream, 8)));
    const Seating expected = lockstep(ladder);
    SwapFlow flow(ladder);
    for (std::uint32_t level = 0; level < flow.size(); ++level)
      flow.sit(level, level, 0);
    std::uint64_t goings = 0;
    for (std::vector<std::uint32_t> may = ready(flow); !may.empty(); may = ready(flow)) {
      // Half of the time, choose the level that is furthest ahead.
      std::uint32_t level = may[below(stream, may.size())];
      if (below(stream, 2) == 0)
        level = *std::ranges::max_element(may, {}, [&](auto l) { return flow.seat(l).scan; });
      const SwapFlow::Seat seat = flow.seat(level);
      for (const SwapFlow::GoesOn& goes : flow.made(level, density(*seat.replica, seat.scan))) {
        ++goings;
        ASSERT_EQ(goes.scan, seat.scan + 1);
        ASSERT_EQ(goes.replica, expected[goes.scan][goes.level]);
        ASSERT_EQ(flow.seat(goes.level).replica, goes.replica);
        ASSERT_TRUE(flow.seat(goes.level).may_run());
      }
      for (std::uint32_t other = 0; other < flow.size(); ++other)
        ahead_most = std::max(ahead_most, flow.seat(level).scan - std::min(flow.seat(level).scan,
                                                                           flow.seat(other).scan));
    }
    // All levels reach the last scan, so no level waits forever.
    EXPECT_EQ(goings, (k_scans - 1) * ladder.levels);
  }
  EXPECT_GE(ahead_most, 4U);
}

TEST(SwapFlow, APartLosesThoseWhosePartnerIsOutside) {
  // Goal: in a part of a ladder, replicas move as in the whole ladder. A replica leaves the part
  // exactly when its swap partner is outside. Method: test all parts of a ladder of eight levels.
  // Parts begin at several first scans. Every part except the whole ladder loses all its replicas.
  const FlowLevels ladder = ladder_of(8);
  const Seating expected = lockstep(ladder);
  for (std::uint32_t first = 0; first < 8; ++first) {
    for (std::uint32_t size = 1; first + size <= 8; ++size) {
      for (const std::uint64_t begin : {0U, 1U, 6U}) {
        SCOPED_TRACE(fmt::format("levels from {}, {} of them, from scan {}", first, size, begin));
        FlowLevels part = ladder;
        part.first_level = first;
        part.inverse_temperatures = {ladder.inverse_temperatures.begin() + first,
                                     ladder.inverse_temperatures.begin() + first + size};
        SwapFlow flow(part);
        for (std::uint32_t level = 0; level < size; ++level)
          flow.sit(level, expected[begin][first + level], begin);
        // The part's levels that have a replica at this scan: a contiguous range, or none.
        std::uint32_t low = 0;
        std::uint32_t high = size;
        for (std::uint64_t scan = begin; scan + 1 < k_scans; ++scan) {
          for (std::uint32_t level = low; level < high; ++level) {
            const SwapFlow::Seat seat = flow.seat(level);
            ASSERT_TRUE(seat.may_run());
            ASSERT_EQ(seat.scan, scan);
            ASSERT_EQ(*seat.replica, expected[scan][first + level]);
          }
          for (std::uint32_t level = low; level < high; ++level)
            flow.made(level, density(expected[scan][first + level], scan));
          const auto outside = [&](std::uint32_t level) {
            const auto partner = even_odd_partner(first + level, scan, 8);
            return partner && (*partner < first + low || *partner >= first + high);
          };
          const bool loses_low = low < high && outside(low);
          const bool loses_high = low + 1 < high && outside(high - 1);
          low += loses_low ? 1 : 0;
          high -= loses_high ? 1 : 0;
        }
        EXPECT_EQ(low < high, size == 8) << "only the whole ladder goes on";
      }
    }
  }
}

TEST(SwapFlowDeathTest, MisuseIsABug) {
  // Goal: the process stops if an empty seat reports a scan, a scan is reported twice, or a part
  // extends beyond the end of its ladder.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  SwapFlow flow(ladder_of(3));
  EXPECT_DEATH(flow.made(0, 0), "check failed");
  flow.sit(0, 0, 0);
  flow.made(0, 0);
  EXPECT_DEATH(flow.made(0, 0), "check failed");
  FlowLevels beyond = ladder_of(3);
  beyond.first_level = 1;
  EXPECT_DEATH(SwapFlow{beyond}, "check failed");
}

}  // namespace sleight::sampling::swap_flow_test
