#include "worker/worlds/spelling/proposals.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <cstdio>
#include <map>

#include "common/math/elementary.h"
#include "tests/support/property.h"

namespace sleight::worlds::spelling::proposals_test {

random::Stream stream_of(std::uint64_t seed, std::uint64_t iteration) {
  return random::Stream({.seed = seed, .purpose = random::Purpose::proposal}, iteration);
}

ProposalParameters only(Kind kind) {
  ProposalParameters p;
  const std::array shares{&p.change_all, &p.change_vertices, &p.change_ball, &p.disable_balls,
                          &p.enable_balls};
  for (std::size_t i = 0; i < shares.size(); ++i)
    *shares[i] = i == static_cast<std::size_t>(kind) ? 1 : 0;
  return p;
}

sampling::Proposal<State> propose(const Prior& prior, const ProposalParameters& p,
                                  const State& state, random::Stream& stream) {
  return propose_of(drawn_kind(p, stream), prior, p, state, {}, stream);
}

State with_active(const Prior& prior, std::uint32_t active) {
  State state;
  state.offsets_m.assign(prior.vertices, Vec3::Zero());
  for (std::uint32_t ball = 0; ball < prior.balls; ++ball) {
    state.active.push_back(ball < active ? 1 : 0);
    state.drops_m.push_back(ball < active ? Vec2(0.1 * ball, 0) : Vec2(0, 0));
  }
  return state;
}

TEST(Proposals, RatiosOfFlipsAreTheFormula) {
  // Goal: the log q ratios of proposals that disable or enable balls follow the header's formula.
  // Method: multiply the probabilities of all balls, for the proposal and for its reverse.
  const Prior prior{.vertices = 0, .balls = 6, .drop_half_m = {0.07, 0.05}};
  const double area = 4 * 0.07 * 0.05;
  const double f = 0.25;
  for (std::uint32_t active = 0; active <= 6; ++active) {
    const State state = with_active(prior, active);
    for (const Kind kind : {Kind::disable_balls, Kind::enable_balls}) {
      for (const std::uint64_t i : property::cases(50)) {
        random::Stream stream = stream_of(i, active);
        const auto proposal = propose(prior, only(kind), state, stream);
        double forward = 1;
        double back = 1;
        for (std::size_t ball = 0; ball < 6; ++ball) {
          const bool was = state.active[ball] != 0;
          const bool is = proposal.candidate.active[ball] != 0;
          if (kind == Kind::disable_balls) {
            if (was) forward *= is ? 1 - f : f;
            if (!is) back *= was ? f / area : 1 - f;
          } else {
            if (!was) forward *= is ? f / area : 1 - f;
            if (is) back *= was ? 1 - f : f;
          }
        }
        EXPECT_NEAR(proposal.log_q_ratio, std::log(back / forward), 1e-12);
        EXPECT_EQ(proposal.kind, static_cast<std::uint32_t>(kind));
      }
    }
  }
}

TEST(Proposals, ChainsKeepADistributionThatCanBeEnumerated) {
  // Goal: the mixture of all kinds of proposals leaves p_w times a constraint invariant. Method:
  // let each of three balls be inactive, in the left half or in the right half. This gives 27
  // cases. A long chain by Algorithm 2.1 must visit each case in proportion to its weight
  // (chi-square on every 40th state). The ratio printed in the thesis must fail, because it lacks
  // powers of 1 - f. Kernel::thesis must fail too.
  const Prior prior{.vertices = 1, .balls = 3, .vertex_sd_m = 1, .drop_half_m = {0.5, 0.3}};
  ProposalParameters parameters;
  parameters.vertex_probability = 0.5;
  parameters.vertex_sd_m = 1;
  parameters.ball_sd_m = 0.5;
  const auto cell_of = [](const State& state) {
    std::size_t cell = 0;
    for (std::size_t ball = 0; ball < 3; ++ball) {
      const std::size_t which = state.active[ball] == 0 ? 0 : (state.drops_m[ball].x() < 0 ? 1 : 2);
      cell = 3 * cell + which;
    }
    return cell;
  };
  // The log weight is proportional to the number of balls in the left half. If a vertex is above 0,
  // the log weight is twice as large.
  const auto log_constraint = [](const State& state) {
    double sum = 0;
    for (std::size_t ball = 0; ball < 3; ++ball)
      sum += state.active[ball] != 0 && state.drops_m[ball].x() < 0 ? 0.8 : 0;
    return sum * (state.offsets_m[0].x() > 0 ? 2 : 1);
  };
  std::array<double, 27> expected{};
  double total = 0;
  for (std::size_t cell = 0; cell < 27; ++cell) {
    double share = 1;
    double left = 0;
    for (std::size_t ball = 0, rest = cell; ball < 3; ++ball, rest /= 3) {
      share *= rest % 3 == 0 ? 0.5 : 0.25;
      left += rest % 3 == 1 ? 0.8 : 0;
    }
    expected[cell] = share * 0.5 * (std::exp(left) + std::exp(2 * left));
    total += expected[cell];
  }
  const auto statistic = [&](std::uint64_t seed, Kernel kernel, bool printed) {
    parameters.kernel = kernel;
    State state = with_active(prior, 1);
    std::array<double, 27> seen{};
    constexpr int k_thin = 40;
    constexpr int k_kept = 5'000;
    for (int i = 0; i < k_thin * k_kept; ++i) {
      random::Stream stream = stream_of(seed, static_cast<std::uint64_t>(i));
      const auto proposal = propose(prior, parameters, state, stream);
      double q = proposal.log_q_ratio;
      // The ratio of thesis A.2.2. The ratio lacks powers of 1 - f, but has the right power of the
      // area.
      if (printed && proposal.kind >= static_cast<std::uint32_t>(Kind::disable_balls)) {
        q = prior.log_area() * (static_cast<double>(proposal.candidate.active_count()) -
                                static_cast<double>(state.active_count()));
      }
      const double log_ratio = prior.log_density(proposal.candidate) - prior.log_density(state) +
                               log_constraint(proposal.candidate) - log_constraint(state) + q;
      if (math::log(stream.uniform()) < log_ratio) state = proposal.candidate;
      if (i % k_thin == 0) ++seen[cell_of(state)];
    }
    double chi_square = 0;
    for (std::size_t cell = 0; cell < 27; ++cell) {
      const double wanted = k_kept * expected[cell] / total;
      chi_square += (seen[cell] - wanted) * (seen[cell] - wanted) / wanted;
    }
    return chi_square;
  };
  const boost::math::chi_squared law(26);
  const double right = statistic(7, Kernel::correct, false);
  const double wrong = statistic(8, Kernel::correct, true);
  const double thesis = statistic(9, Kernel::thesis, false);
  std::printf("chi-square %.1f with the ratios, %.1f without, %.1f as printed\n", right, wrong,
              thesis);
  EXPECT_LT(right, boost::math::quantile(law, 1 - 1e-4));
  EXPECT_GT(wrong, boost::math::quantile(law, 1 - 1e-12));
  EXPECT_GT(thesis, boost::math::quantile(law, 1 - 1e-12));
}

TEST(Proposals, ThesisRatiosAreThosePrinted) {
  // Goal: Kernel::thesis uses the ratio printed in thesis A.2.2. Each disabled ball contributes the
  // factor a, which is the area. Each enabled ball contributes 1/a. Proposals of other kinds have
  // ratio 1. Method: test draws of each kind.
  const Prior prior{.vertices = 5, .balls = 6, .drop_half_m = {0.07, 0.05}};
  const double log_area = std::log(4 * 0.07 * 0.05);
  for (std::uint32_t kind = 0; kind < k_thesis_kinds; ++kind) {
    ProposalParameters parameters = only(static_cast<Kind>(kind));
    parameters.kernel = Kernel::thesis;
    for (const std::uint64_t i : property::cases(100)) {
      const State state = with_active(prior, static_cast<std::uint32_t>(i % 7));
      random::Stream stream = stream_of(i, kind);
      const auto proposal = propose(prior, parameters, state, stream);
      const double disabled = static_cast<double>(state.active_count()) -
                              static_cast<double>(proposal.candidate.active_count());
      const bool flips = kind >= static_cast<std::uint32_t>(Kind::disable_balls);
      EXPECT_NEAR(proposal.log_q_ratio, flips ? disabled * log_area : 0, 1e-12);
      EXPECT_EQ(proposal.kind, kind);
    }
  }
}

TEST(Proposals, ThesisOffsetsAreLengthsInDirections) {
  // Goal: Kernel::thesis draws an offset's direction uniformly. From the Gaussian, it draws the
  // offset's length instead of its coordinates. Kernel::thesis does this at the start, in
  // change_all and in change_vertices. Method: check that the mean square length is sd^2, and that
  // each coordinate contributes a third. The Gaussian density that scores the offset has a mean
  // square length of 3 sd^2. So the mean exponent of p_w is -1/2 per vertex.
  const Prior prior{.vertices = 100, .balls = 2, .vertex_sd_m = 1e-4, .drop_half_m = {0.07, 0.05}};
  constexpr double k_draws = 400;
  const auto mean_square = [&](double sd, const auto& draw) {
    Vec3 sum = Vec3::Zero();
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(k_draws); ++i) {
      random::Stream stream = stream_of(51, i);
      for (const Vec3& offset_m : draw(stream).offsets_m)
        sum += offset_m.cwiseProduct(offset_m) / (sd * sd * k_draws * prior.vertices);
    }
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(sum[axis], 1.0 / 3, 0.015);
    return sum.sum();
  };
  ProposalParameters parameters = only(Kind::change_all);
  parameters.kernel = Kernel::thesis;
  parameters.vertex_probability = 1;
  const State zero = with_active(prior, 0);
  const double start = mean_square(
      1e-4, [&](random::Stream& stream) { return draw_state(prior, Kernel::thesis, stream); });
  EXPECT_NEAR(start, 1, 0.03);
  const double all = mean_square(1e-4, [&](random::Stream& stream) {
    return propose(prior, parameters, zero, stream).candidate;
  });
  EXPECT_NEAR(all, 1, 0.03);
  parameters.change_all = 0;
  parameters.change_vertices = 1;
  const double moved = mean_square(parameters.vertex_sd_m, [&](random::Stream& stream) {
    return propose(prior, parameters, zero, stream).candidate;
  });
  EXPECT_NEAR(moved, 1, 0.03);
}

TEST(Proposals, KindsHaveTheirShares) {
  // Goal: each kind of proposal occurs with its share, and a kind with share 0 never occurs.
  const Prior prior{.vertices = 3, .balls = 4, .drop_half_m = {0.2, 0.05}};
  const ProposalParameters parameters{.change_all = 0.1,
                                      .change_vertices = 0.7 - 1e-10,
                                      .change_ball = 0.2,
                                      .disable_balls = 0,
                                      .enable_balls = 0,
                                      .vertex_probability = 1,
                                      .vertex_sd_m = 1};
  std::array<int, k_kinds> seen{};
  for (const std::uint64_t i : property::cases(10'000)) {
    random::Stream stream = stream_of(41, i);
    const State state = with_active(prior, 2);
    const auto proposal = propose(prior, parameters, state, stream);
    ++seen[proposal.kind];
    if (proposal.kind == static_cast<std::uint32_t>(Kind::change_all)) {
      EXPECT_NEAR(proposal.log_q_ratio,
                  prior.log_density(state) - prior.log_density(proposal.candidate), 1e-12);
    } else {
      EXPECT_EQ(proposal.log_q_ratio, 0);
    }
    if (proposal.kind == static_cast<std::uint32_t>(Kind::change_vertices)) {
      EXPECT_EQ(proposal.candidate.drops_m, state.drops_m);
      EXPECT_NE(proposal.candidate.offsets_m, state.offsets_m);
    }
  }
  if (!property::all_cases()) return;
  EXPECT_NEAR(seen[0], 1000, 150);
  EXPECT_NEAR(seen[1], 7000, 230);
  EXPECT_NEAR(seen[2], 2000, 200);
  EXPECT_EQ(seen[3] + seen[4], 0);
}

TEST(Proposals, DrawsBelongToTheDensity) {
  // Goal: log p_w is the normalised density of the prior's draws. Method: compare the mean of log
  // p_w over 2000 draws with the negative entropy. The entropy has a closed form. Also check the
  // offsets' standard deviation, and that half of the balls are active.
  const Prior prior{.vertices = 40, .balls = 10, .vertex_sd_m = 1e-4, .drop_half_m = {0.07, 0.05}};
  double log_density = 0;
  double square = 0;
  double active = 0;
  constexpr int k_draws = 2000;
  for (int i = 0; i < k_draws; ++i) {
    random::Stream stream = stream_of(21, static_cast<std::uint64_t>(i));
    const State state = draw_state(prior, Kernel::correct, stream);
    log_density += prior.log_density(state) / k_draws;
    for (const Vec3& offset_m : state.offsets_m)
      square += math::dot(offset_m, offset_m) / (k_draws * 120.0);
    active += state.active_count() / (k_draws * 10.0);
  }
  EXPECT_NEAR(std::sqrt(square), 1e-4, 1e-6);
  EXPECT_NEAR(active, 0.5, 0.015);
  const double of_offsets = -120 * (0.5 * std::log(2 * M_PI * std::exp(1.0)) + std::log(1e-4));
  const double of_balls = -10 * std::log(2.0) - 5 * std::log(4 * 0.07 * 0.05);
  EXPECT_NEAR(log_density, of_offsets + of_balls, 0.8);
}

TEST(Proposals, ABallMovesOnARing) {
  // Goal: moving a ball changes only its drop place. The place wraps at the region's edges, so it
  // stays in the region. Method: make many moves. Most moves are about as long as the region.
  const Prior prior{.vertices = 2, .balls = 3, .drop_half_m = {0.07, 0.05}};
  State state = with_active(prior, 2);
  state.drops_m[1] = {0.06, -0.04};
  std::map<std::size_t, int> moved;
  for (const std::uint64_t i : property::cases(1000)) {
    random::Stream stream = stream_of(31, i);
    ProposalParameters parameters = only(Kind::change_ball);
    parameters.ball_sd_m = 0.1;
    const auto proposal = propose(prior, parameters, state, stream);
    EXPECT_EQ(proposal.log_q_ratio, 0);
    EXPECT_EQ(proposal.candidate.active, state.active);
    EXPECT_EQ(proposal.candidate.offsets_m, state.offsets_m);
    for (std::size_t ball = 0; ball < 3; ++ball) {
      const Vec2& drop_m = proposal.candidate.drops_m[ball];
      EXPECT_LE(std::fabs(drop_m.x()), 0.07);
      EXPECT_LE(std::fabs(drop_m.y()), 0.05);
      if (drop_m != state.drops_m[ball]) ++moved[ball];
    }
  }
  if (!property::all_cases()) return;
  EXPECT_GT(moved[0], 440);
  EXPECT_GT(moved[1], 440);
  EXPECT_EQ(moved[2], 0);
}

}  // namespace sleight::worlds::spelling::proposals_test
