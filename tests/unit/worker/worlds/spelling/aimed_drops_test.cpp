#include "worker/worlds/spelling/aimed_drops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "common/random/stream.h"
#include "tests/support/property.h"
#include "worker/worlds/spelling/spelling.h"

namespace sleight::worlds::spelling::aimed_drops_test {

constexpr ProposalParameters k_aims{.aim_ball = 0.3, .scatter_ball = 0.2};

struct Case {
  Prior prior{.vertices = 0, .balls = 6, .vertex_sd_m = 1, .drop_half_m = {0.05, 0.03}};
  Windows windows;
  State state;
  Filling filling;
};

/// Six bins in a row and six balls. Some balls fill random bins.
Case random_case(random::Stream& stream) {
  Case made;
  for (int bin = 0; bin < 6; ++bin)
    made.windows.add({-0.045 + 0.018 * bin, 0.004 * bin - 0.01}, 0.018, made.prior.drop_half_m);
  made.state = draw_state(made.prior, Kernel::correct, stream);
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

std::size_t the_changed_ball(const State& a, const State& b) {
  std::vector<std::size_t> changed;
  for (std::size_t ball = 0; ball < a.active.size(); ++ball) {
    if (a.active[ball] != b.active[ball] || a.drops_m[ball] != b.drops_m[ball])
      changed.push_back(ball);
  }
  EXPECT_EQ(changed.size(), 1U);
  return changed.empty() ? 0 : changed.front();
}

TEST(AimedDrops, ChangeOneBallOfTheRightKind) {
  // Goal: aiming moves a ball that fills no bin, and scattering moves a ball that fills a bin.
  // Without such a ball, there is no proposal. Each candidate has a finite prior density. Method:
  // propose both kinds of moves for random states.
  for (const std::uint64_t i : property::cases(2000)) {
    random::Stream stream = stream_of(i);
    const Case made = random_case(stream);
    const auto loose = std::ranges::count(made.filling, k_fills_none);
    const auto aimed = aim_ball(made.prior, made.windows, k_aims, made.state, made.filling, stream);
    ASSERT_EQ(aimed.has_value(), loose > 0);
    if (aimed) {
      const std::size_t ball = the_changed_ball(made.state, aimed->candidate);
      EXPECT_EQ(made.filling[ball], k_fills_none);
      EXPECT_EQ(aimed->candidate.active[ball], 1);
      EXPECT_TRUE(std::isfinite(made.prior.log_density(aimed->candidate)));
      EXPECT_TRUE(aimed->ratio_waits);
    }
    const auto scattered =
        scatter_ball(made.prior, made.windows, k_aims, made.state, made.filling, stream);
    ASSERT_EQ(scattered.has_value(), loose < 6);
    if (scattered) {
      EXPECT_NE(made.filling[the_changed_ball(made.state, scattered->candidate)], k_fills_none);
      EXPECT_TRUE(std::isfinite(made.prior.log_density(scattered->candidate)));
      EXPECT_TRUE(scattered->ratio_waits);
    }
  }
}

TEST(AimedDrops, AreEachOthersWayBack) {
  // Goal: the ratio of aiming from state A to state C is the inverse of the ratio of scattering
  // from C to A. No ratio exceeds its bound. A ratio is finite only if the reverse proposal is
  // possible. Method: propose both kinds of moves for random states, and give each candidate a
  // random filling.
  std::uint64_t ways_back = 0;
  for (const std::uint64_t i : property::cases(4000)) {
    random::Stream stream = stream_of(i);
    const Case made = random_case(stream);
    const Filling there = random_case(stream).filling;
    if (const auto aimed =
            aim_ball(made.prior, made.windows, k_aims, made.state, made.filling, stream)) {
      const double ratio = aim_log_q_ratio(made.prior, made.windows, k_aims, made.state,
                                           made.filling, aimed->candidate, there);
      const double back = scatter_log_q_ratio(made.prior, made.windows, k_aims, aimed->candidate,
                                              there, made.state, made.filling);
      const std::size_t ball = the_changed_ball(made.state, aimed->candidate);
      ASSERT_EQ(std::isfinite(ratio), there[ball] != k_fills_none) << i;
      EXPECT_LE(ratio, aimed->log_q_ratio) << i;
      if (std::isfinite(ratio)) {
        EXPECT_EQ(ratio, -back) << i;
        ++ways_back;
      }
    }
    if (const auto scattered =
            scatter_ball(made.prior, made.windows, k_aims, made.state, made.filling, stream)) {
      const double ratio = scatter_log_q_ratio(made.prior, made.windows, k_aims, made.state,
                                               made.filling, scattered->candidate, there);
      const std::size_t ball = the_changed_ball(made.state, scattered->candidate);
      ASSERT_EQ(std::isfinite(ratio), there[ball] == k_fills_none) << i;
      EXPECT_LE(ratio, scattered->log_q_ratio) << i;
      if (std::isfinite(ratio)) ++ways_back;
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(ways_back, 1000U);
}

TEST(AimedDrops, HaveTheRatioOfTheirProbabilities) {
  // Goal: the ratios of aiming and scattering follow the header's formula. Method: let one of four
  // balls fill a bin. Aim the second ball, which was dropped elsewhere or was inactive.
  const Prior prior{.vertices = 0, .balls = 4, .vertex_sd_m = 1, .drop_half_m = {0.05, 0.03}};
  Windows windows;
  for (const double x_m : {-0.03, -0.01, 0.01, 0.03})
    windows.add({x_m, 0}, 0.02, prior.drop_half_m);
  for (const bool was_active : {false, true}) {
    State state{.offsets_m = {},
                .active = {1, 0, 0, 1},
                .drops_m = {Vec2(-0.03, 0), Vec2(0, 0), Vec2(0, 0), Vec2(0.04, 0.02)}};
    if (was_active) {
      state.active[1] = 1;
      state.drops_m[1] = {-0.04, 0.01};
    }
    State candidate = state;
    candidate.active[1] = 1;
    candidate.drops_m[1] = {0.031, 0.001};
    const Filling filling{0, k_fills_none, k_fills_none, k_fills_none};
    const Filling there{0, 3, k_fills_none, k_fills_none};
    // The proposal aims one of three loose balls at one of three bins. The way back scatters one of
    // the two balls that fill a bin.
    double density_pm2 = 0;
    for (const std::size_t bin : {1, 2, 3})
      density_pm2 += windows.density(std::span(&bin, 1), candidate.drops_m[1]) / 3;
    const double aim = k_aims.aim_ball / 3 * density_pm2;
    const double scatter = k_aims.scatter_ball / 2 * (was_active ? 0.5 / (0.1 * 0.06) : 0.5);
    EXPECT_NEAR(aim_log_q_ratio(prior, windows, k_aims, state, filling, candidate, there),
                std::log(scatter / aim), 1e-13);
    EXPECT_NEAR(scatter_log_q_ratio(prior, windows, k_aims, candidate, there, state, filling),
                std::log(aim / scatter), 1e-13);
  }
}

TEST(Windows, DrawWhatTheirDensitySays) {
  // Goal: a window's draws have the documented density. Method: draw a million places around a bin
  // at the edge, and count them in cells of 2 mm. Compare each count with the density in the middle
  // of the cell, within six standard deviations.
  Windows windows;
  const Vec2 half_m(0.05, 0.03);
  windows.add({-0.045, 0.011}, 0.02, half_m);
  windows.add({0.01, 0}, 0.02, half_m);
  constexpr int k_columns = 50;
  constexpr int k_rows = 30;
  constexpr double k_draws = 1e6;
  std::vector<double> counts(std::size_t{k_columns} * k_rows, 0);
  random::Stream stream = stream_of(0);
  for (int i = 0; i < static_cast<int>(k_draws); ++i) {
    const Vec2 drop_m = windows.draw(0, stream);
    const auto column = static_cast<int>((drop_m.x() + half_m.x()) / 0.002);
    const auto row = static_cast<int>((drop_m.y() + half_m.y()) / 0.002);
    ASSERT_TRUE(column >= 0 && column < k_columns && row >= 0 && row < k_rows);
    ++counts[static_cast<std::size_t>(row * k_columns + column)];
  }
  const std::size_t bin[] = {0};
  double cells = 0;
  for (int row = 0; row < k_rows; ++row) {
    for (int column = 0; column < k_columns; ++column) {
      const Vec2 low_m(-half_m.x() + 0.002 * column, -half_m.y() + 0.002 * row);
      // Skip cells in which the density is not constant.
      const double density_pm2 = windows.density(bin, low_m + Vec2(0.001, 0.001));
      const Vec2 corners[] = {low_m + Vec2(1e-6, 1e-6), low_m + Vec2(0.001999, 1e-6),
                              low_m + Vec2(1e-6, 0.001999), low_m + Vec2(0.001999, 0.001999)};
      if (std::ranges::any_of(corners, [&](const Vec2& corner_m) {
            return windows.density(bin, corner_m) != density_pm2;
          }))
        continue;
      const double expected = density_pm2 * 0.002 * 0.002 * k_draws;
      EXPECT_NEAR(counts[static_cast<std::size_t>(row * k_columns + column)], expected,
                  6 * std::sqrt(expected));
      const std::size_t both[] = {0, 1};
      EXPECT_LE(windows.density(both, low_m + Vec2(0.001, 0.001)),
                windows.greatest_density(low_m + Vec2(0.001, 0.001)));
      ++cells;
    }
  }
  EXPECT_GT(cells, 1000);
}

TEST(AimedDrops, KnowWhatEachBallFills) {
  // Goal: the outcome's `filling` names the same balls as balls_of_bins(). Method: compare
  // `filling` with balls_of_bins() for prior draws of HI.
  const Spelling world{Parameters{}};
  for (const std::uint64_t i : property::cases(40)) {
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

}  // namespace sleight::worlds::spelling::aimed_drops_test
