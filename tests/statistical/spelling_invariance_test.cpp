// Tests that all proposals for balls that spell leave p_w p_c^beta invariant, although the number
// of balls varies. The test rejects the ratios that A.2.2 of the thesis prints.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "common/math/elementary.h"
#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/rank_tests.h"
#include "tests/statistical/support/spelling_fixture.h"
#include "tests/support/property.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/surrogate_transition.h"

namespace sleight::statistical::spelling_invariance_test {

using worlds::spelling::Kernel;

constexpr std::uint64_t k_seed = 535897;

/// The fast tier has just enough chains to reject each of the wrong kernels below.
std::size_t chain_count() {
  return property::long_run() ? 40'000 : property::of_tier(1200, 2000);
}

/// The tested quantities are the places of drops, an offset, the sum of all squared offsets, and a
/// cell number. The cell number combines the set of active balls with the number of filled bins.
struct Functions {
  static constexpr std::size_t k_cells = 4 * 3;
  std::array<double, k_cells> cells{};
  std::array<std::vector<double>, 5> values;

  void add(const SpellingSample& sample) {
    const auto& state = sample.state;
    const std::size_t active = state.active[0] + 2U * state.active[1];
    cells[active * 3 + sample.outcome.filled] += 1;
    if (state.active[0] != 0) values[0].push_back(state.drops_m[0].x());
    if (state.active[1] != 0) values[1].push_back(std::fabs(state.drops_m[1].x()));
    if (state.active[1] != 0) values[2].push_back(state.drops_m[1].y());
    values[3].push_back(state.offsets_m[0].z());
    double sum = 0;
    for (const auto& offset_m : state.offsets_m)
      sum += math::dot(offset_m, offset_m);
    values[4].push_back(sum);
  }
};

/// Compares moved exact draws with fresh exact draws. Returns the least p-value times the number of
/// tests.
template <class World>
double least_p(const World& world, double beta, std::uint64_t steps) {
  const Spelling exact = world_with(Kernel::correct);
  Functions moved;
  Functions fresh;
  for (std::size_t i = 0; i < chain_count(); ++i) {
    const auto streams = [&](std::size_t chain) {
      return sampling::ChainStreams{.seed = k_seed,
                                    .chain = base::ChainId{static_cast<std::uint32_t>(chain)},
                                    .replica = base::ReplicaId{0}};
    };
    random::Stream start = streams(2 * i).at(random::Purpose::prior, 0);
    const SpellingSample drawn = exact_draw(exact, beta, start);
    sampling::Sample<World> sample{drawn.state, drawn.outcome, drawn.log_prior,
                                   drawn.log_constraint};
    for (std::uint64_t step = 1; step <= steps; ++step)
      sampling::iterate(world, beta, streams(2 * i), step, sample, {},
                        [](const sampling::StepReport&) {});
    moved.add({sample.state, sample.outcome, sample.log_prior, sample.log_constraint});
    random::Stream other = streams(2 * i + 1).at(random::Purpose::prior, 0);
    fresh.add(exact_draw(exact, beta, other));
  }
  double least = two_sample_p(moved.cells, fresh.cells);
  for (std::size_t f = 0; f < moved.values.size(); ++f)
    least = std::min(least, kolmogorov_smirnov_p(moved.values[f], fresh.values[f]));
  return static_cast<double>(1 + moved.values.size()) * least;
}

class SpellingInvariance : public testing::TestWithParam<std::tuple<double, std::uint64_t>> {};

TEST_P(SpellingInvariance, ExactDrawsStayExact) {
  // Goal: the kernel, which also changes the number of active balls, leaves p_w p_c^beta invariant.
  // Method: make exact draws by rejection, move them with the kernel, and compare them with fresh
  // exact draws. The test fails by chance once in 10^4 runs.
  const auto [beta, steps] = GetParam();
  const double p = least_p(world_with(Kernel::correct), beta, steps);
  std::printf("beta %g, %d steps: p %g\n", beta, static_cast<int>(steps), p);
  EXPECT_GT(p, 1e-4) << "seed " << k_seed;
}

TEST_P(SpellingInvariance, AimedDropsKeepExactDrawsExact) {
  // Goal: proposals by outcome leave p_w p_c^beta invariant. The ratio of such a proposal depends
  // on the outcome, and is known only after the simulation. Method: compare moved exact draws with
  // fresh exact draws. Most proposals are of this kind.
  const auto [beta, steps] = GetParam();
  const double p = least_p(Spelling(parameters_with_aims()), beta, steps);
  std::printf("aimed, beta %g, %d steps: p %g\n", beta, static_cast<int>(steps), p);
  EXPECT_GT(p, 1e-4) << "seed " << k_seed;
}

Spelling with_redraws() {
  worlds::spelling::Parameters parameters = world_with(Kernel::correct).parameters();
  worlds::spelling::ProposalParameters& p = parameters.proposal;
  p.change_all = 0.02;
  p.change_vertices = 0.6;
  p.vertex_redraw = 0.7;
  p.change_ball = 0.1;
  p.disable_balls = p.enable_balls = 0.09;
  p.aim_ball = p.scatter_ball = 0.05;
  return Spelling(parameters);
}

TEST_P(SpellingInvariance, RedrawsKeepExactDrawsExact) {
  // Goal: redrawing vertices leaves p_w p_c^beta invariant. Method: compare moved exact draws with
  // fresh exact draws. Many proposals redraw vertices.
  const auto [beta, steps] = GetParam();
  const double p = least_p(with_redraws(), beta, steps);
  std::printf("redrawn, beta %g, %d steps: p %g\n", beta, static_cast<int>(steps), p);
  EXPECT_GT(p, 1e-4) << "seed " << k_seed;
}

/// A wrong kernel. It treats redraws as symmetric.
struct CarelessRedraws : Spelling {
  using Spelling::propose;
  using Spelling::Spelling;
  sampling::Proposal<State> propose(const State& state, const Outcome& outcome,
                                    std::span<const double> scales, random::Stream& stream) const {
    auto proposal = Spelling::propose(state, outcome, scales, stream);
    if (proposal.kind == static_cast<std::uint32_t>(worlds::spelling::Kind::change_vertices))
      proposal.log_q_ratio = 0;
    return proposal;
  }
};

TEST(SpellingInvarianceOfCarelessRedraws, IsRefuted) {
  // Goal: the redraw test rejects a kernel whose redraws count the prior twice.
  const CarelessRedraws careless(with_redraws().parameters());
  EXPECT_LT(least_p(careless, 1, 60), 1e-6);
}

/// A wrong kernel. The kernel uses an upper bound of scatter_ball's ratio as if it were the ratio.
struct Hasty : Spelling {
  using Spelling::Spelling;
  double log_q_ratio(const State& /*state*/, const Outcome& /*outcome*/,
                     const sampling::Proposal<State>& proposal,
                     const Outcome& /*candidate_outcome*/) const {
    return proposal.log_q_ratio;
  }
};

TEST(SpellingInvarianceOfAHastyRatio, IsRefuted) {
  // Goal: the test of proposals by outcome rejects a ratio that ignores the outcome.
  const double p = least_p(Hasty(parameters_with_aims()), 1.0, 40);
  std::printf("hasty, 40 steps: p %g\n", p);
  EXPECT_LT(p, 1e-9);
}

TEST_P(SpellingInvariance, SoloStepsKeepExactDrawsExact) {
  // Goal: walks and anchored steps leave p_w p_c^beta invariant. Simulations of balls alone judge
  // each proposal first. Method: compare moved exact draws with fresh exact draws.
  const auto [beta, steps] = GetParam();
  const double p = least_p(Spelling(parameters_with_solo_steps()), beta, steps);
  std::printf("solo, beta %g, %d steps: p %g\n", beta, static_cast<int>(steps), p);
  EXPECT_GT(p, 1e-4) << "seed " << k_seed;
}

/// A wrong kernel. The kernel anchors all balls that fill a bin, and omits the probability of the
/// reverse move.
struct Stubborn : Spelling {
  using Spelling::Spelling;
  Anchor draw_anchor(const State& state, const Outcome& outcome,
                     const worlds::spelling::SoloBalls::Outcome& /*solo*/, double /*keep*/,
                     random::Stream& /*stream*/) const {
    return {.bins = outcome.filling, .drops_m = state.drops_m};
  }
  double log_anchor_probability(const Anchor& /*anchor*/, const Outcome& /*outcome*/,
                                const worlds::spelling::SoloBalls::Outcome& /*solo*/,
                                double /*keep*/) const {
    return 0;
  }
};

TEST(SpellingInvarianceOfStubbornAnchors, IsRefuted) {
  // Goal: the test of solo steps rejects a kernel that omits the anchors' probabilities.
  const double p = least_p(Stubborn(parameters_with_solo_steps()), 1.0, 10);
  std::printf("stubborn, 10 steps: p %g\n", p);
  EXPECT_LT(p, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Betas, SpellingInvariance,
                         testing::Combine(testing::Values(0.0, 1.0),
                                          testing::Values(std::uint64_t{1}, std::uint64_t{10})));

TEST(SpellingInvarianceOfThePrintedKernel, IsRefuted) {
  // Goal: the invariance test rejects the kernel that A.2.2 of the thesis prints.
  EXPECT_LT(least_p(world_with(Kernel::thesis), 1.0, 10), 1e-9);
}

}  // namespace sleight::statistical::spelling_invariance_test
