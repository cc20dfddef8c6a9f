#include "worker/worlds/spelling/aimed_drops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/random/stream.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling {
namespace {

constexpr AimParameters k_aims{.aim = 0.3, .scatter = 0.2};

struct Case {
  Prior prior{.vertices = 0, .balls = 6, .vertex_sd_m = 1, .drop_half_m = {0.05, 0.03}};
  Windows windows;
  State state;
  Filling filling;
};

/// Six windows of different sizes, any balls, any bins that they fill.
Case random_case(random::Stream& stream) {
  Case made;
  for (int bin = 0; bin < 6; ++bin) {
    const double x = -0.05 + 0.1 * bin / 6;
    made.windows.low_m.push_back({x, -0.02});
    made.windows.high_m.push_back({x + 0.01 + 0.001 * bin, 0.02});
  }
  made.state = made.prior.draw(stream);
  made.filling.assign(6, k_fills_none);
  for (std::size_t ball = 0; ball < 6; ++ball) {
    const auto bin = static_cast<std::int16_t>(stream.bits() % 6);
    const bool is_empty = std::ranges::find(made.filling, bin) == made.filling.end();
    if (made.state.active[ball] != 0 && is_empty && stream.uniform() < 0.5)
      made.filling[ball] = bin;
  }
  return made;
}

random::Stream stream_of(std::uint64_t number) {
  return random::Stream({.seed = 8128, .purpose = random::Purpose::scene}, number);
}

TEST(AimedDrops, DropALooseBallAboveAnEmptyBin) {
  // Goal: one ball changes, which filled nothing, and it is dropped above a designated bin that was
  // empty; nothing where all are full. Method: random animations.
  for (std::uint64_t i = 0; i < 2000; ++i) {
    random::Stream stream = stream_of(i);
    const Case made = random_case(stream);
    const auto proposal =
        aim_ball(made.prior, made.windows, k_aims, made.state, made.filling, stream);
    const bool all_full = std::ranges::find(made.filling, k_fills_none) == made.filling.end();
    ASSERT_EQ(proposal.has_value(), !all_full);
    if (!proposal) continue;
    std::size_t changed = 0;
    for (std::size_t ball = 0; ball < 6; ++ball) {
      if (proposal->candidate.drops_m[ball] == made.state.drops_m[ball]) continue;
      ++changed;
      EXPECT_EQ(made.filling[ball], k_fills_none);
      EXPECT_EQ(proposal->candidate.active[ball], 1);
      const auto bin = made.windows.above(proposal->candidate.drops_m[ball]);
      ASSERT_TRUE(bin.has_value());
      EXPECT_EQ(std::ranges::find(made.filling, static_cast<std::int16_t>(*bin)),
                made.filling.end());
    }
    EXPECT_EQ(changed, 1U);
    EXPECT_FALSE(proposal->ratio_waits);
  }
}

TEST(AimedDrops, AreEachOthersWayBack) {
  // Goal: the ratio from A to C by aiming is the inverse of that from C to A by scattering, and
  // scattering's bound is never below its ratio. Method: both, of random animations; of scattered
  // ones with any filling of the candidate.
  std::uint64_t ways_back = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    random::Stream stream = stream_of(i);
    const Case made = random_case(stream);
    if (const auto aimed =
            aim_ball(made.prior, made.windows, k_aims, made.state, made.filling, stream)) {
      const double back = scatter_log_q_ratio(made.prior, made.windows, k_aims, aimed->candidate,
                                              made.state, made.filling);
      EXPECT_NEAR(aimed->log_q_ratio, -back, 1e-12) << i;
    }
    const auto scattered = scatter_ball(made.prior, made.windows, k_aims, made.state, stream);
    EXPECT_TRUE(scattered.ratio_waits);
    const Case other = random_case(stream);
    const double ratio = scatter_log_q_ratio(made.prior, made.windows, k_aims, made.state,
                                             scattered.candidate, other.filling);
    if (scattered.candidate == made.state) continue;
    EXPECT_LE(ratio, scattered.log_q_ratio) << i;
    if (std::isfinite(ratio)) ++ways_back;
  }
  EXPECT_GT(ways_back, 100U);
}

TEST(AimedDrops, KnowWhatEachBallFills) {
  // Goal: the outcome's filling is that of balls_of_bins, as many as are filled. Method: prior
  // draws of HI with all balls.
  const Spelling world{Parameters{}};
  for (std::uint64_t i = 0; i < 40; ++i) {
    random::Stream stream = stream_of(i);
    const State state = world.draw_prior(stream);
    const Outcome outcome = world.simulate(state);
    ASSERT_EQ(outcome.filling.size(), world.balls());
    std::uint32_t filled = 0;
    std::vector<int> by_number(world.balls(), -1);
    for (std::size_t ball = 0; ball < outcome.filling.size(); ++ball) {
      if (outcome.filling[ball] == k_fills_none) continue;
      ++filled;
      by_number[static_cast<std::size_t>(outcome.filling[ball])] = static_cast<int>(ball);
    }
    EXPECT_EQ(filled, outcome.filled);
    std::vector<int> expected;
    const std::vector<int> of_bins = world.balls_of_bins(state);
    for (std::uint32_t row = 0; row < world.bins().rows(); ++row) {
      for (std::uint32_t column = 0; column < world.bins().columns(); ++column) {
        if (world.parameters().pattern.at(column, world.bins().rows() - 1 - row))
          expected.push_back(of_bins[row * world.bins().columns() + column]);
      }
    }
    EXPECT_EQ(by_number, expected) << i;
  }
}

}  // namespace
}  // namespace sleight::worlds::spelling
