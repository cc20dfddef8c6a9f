// Tests transitions by a bad surrogate on six states. Compares the states after transitions with
// the exact distribution.
#include "worker/sampling/surrogate_transition.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/support/numbers.h"
#include "tests/support/property.h"
#include "tests/unit/common/random/chi_square.h"

namespace sleight::sampling::surrogate_transition_test {

constexpr std::size_t k_states = 6;
using Row = std::array<double, k_states>;

constexpr Row k_prior{0.1, 0.25, 0.2, 0.15, 0.2, 0.1};
constexpr Row k_log_constraint{-0.2, -1.5, 0, -k_infinity, -0.7, -1};
constexpr Row k_guess{-1.2, 0, -0.9, -0.5, -0.1, -2};
/// Parts of each state, one bit each. The simulation determines which parts a state has; the
/// surrogate doesn't.
constexpr std::array<std::uint32_t, k_states> k_parts{0b01, 0b00, 0b11, 0b10, 0b11, 0b01};

/// A step to a neighbour in a ring, more often clockwise.
Proposal<std::size_t> stepped(std::size_t state, random::Stream& stream) {
  constexpr double k_clockwise = 0.7;
  const bool clockwise = stream.uniform() < k_clockwise;
  const double odds = std::log((1 - k_clockwise) / k_clockwise);
  return {.candidate = (state + (clockwise ? 1 : k_states - 1)) % k_states,
          .log_q_ratio = clockwise ? odds : -odds};
}

std::size_t drawn(const Row& weights, random::Stream& stream) {
  double u = stream.uniform() * std::accumulate(weights.begin(), weights.end(), 0.0);
  std::size_t state = 0;
  while (state + 1 < k_states && u >= weights[state])
    u -= weights[state++];
  return state;
}

struct RingPart {
  using State = std::size_t;
  using Outcome = std::size_t;
  State draw_prior(random::Stream& stream) const { return drawn(k_prior, stream); }
  double log_prior(const State& state) const { return std::log(k_prior[state]); }
  Outcome simulate(const State& state) const { return state; }
  bool satisfied(const Outcome& outcome) const { return outcome == 2; }
  std::uint32_t proposal_kinds() const { return 3; }
  Proposal<State> propose(const State& state, random::Stream& stream) const {
    return stepped(state, stream);
  }
};

struct GuessedRing : RingPart {
  std::uint32_t anchor = 0;
  Outcome simulate_from(const State& state, const State& /*from*/,
                        const Outcome& /*of_from*/) const {
    return state;
  }
  /// Returns a higher density if the anchored parts still exist.
  double log_constraint(const Outcome& outcome) const {
    return k_guess[outcome] + 0.8 * std::popcount(anchor & k_parts[outcome]);
  }
};

struct Ring : RingPart {
  using Surrogate = GuessedRing;
  using Anchor = std::uint32_t;
  SurrogateSteps steps{};

  double log_constraint(const Outcome& outcome) const { return k_log_constraint[outcome]; }
  Surrogate surrogate(const Anchor& anchor) const {
    Surrogate surrogate;
    surrogate.anchor = anchor;
    return surrogate;
  }
  Anchor draw_anchor(const State& /*state*/, const Outcome& outcome, const Outcome& /*guessed*/,
                     double keep, random::Stream& stream) const {
    Anchor anchor = 0;
    for (const Anchor part : {1U, 2U}) {
      if ((k_parts[outcome] & part) != 0 && stream.uniform() < keep) anchor |= part;
    }
    return anchor;
  }
  double log_anchor_probability(const Anchor& anchor, const Outcome& outcome,
                                const Outcome& /*guessed*/, double keep) const {
    const std::uint32_t parts = k_parts[outcome];
    if ((anchor & ~parts) != 0) return -k_infinity;
    return std::log(std::pow(keep, std::popcount(anchor)) *
                    std::pow(1 - keep, std::popcount(parts) - std::popcount(anchor)));
  }
  SurrogateSteps surrogate_steps(std::span<const double> /*scales*/) const { return steps; }
};
static_assert(HasSurrogate<Ring>);

/// A faulty ring, which ignores the anchors' probabilities.
struct ForgetfulRing : Ring {
  double log_anchor_probability(const Anchor& /*anchor*/, const Outcome& /*outcome*/,
                                const Outcome& /*guessed*/, double /*keep*/) const {
    return 0;
  }
};
static_assert(HasSurrogate<ForgetfulRing>);

Row target_at(double beta) {
  Row weights{};
  for (std::size_t state = 0; state < k_states; ++state)
    weights[state] = std::exp(std::log(k_prior[state]) + beta * k_log_constraint[state]);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights)
    weight /= sum;
  return weights;
}

/// Makes exact draws, moves each once, and returns the p-value of their distribution.
template <class World, class Move>
double p_of(const World& world, double beta, const Move& move) {
  constexpr std::uint64_t k_draws = 100'000;
  const Row target = target_at(beta);
  std::array<int, k_states> counts{};
  for (const std::uint64_t i : property::seeds(k_draws)) {
    const ChainStreams streams{.seed = random::k_test_seed, .chain = {}, .replica = {}};
    random::Stream start = streams.at(random::Purpose::prior, i);
    Sample<World> sample = evaluate(world, drawn(target, start));
    move(streams, i, sample);
    ++counts[sample.state];
    EXPECT_EQ(sample.log_constraint, k_log_constraint[sample.state]);
    EXPECT_EQ(sample.log_prior, world.log_prior(sample.state));
  }
  if (!property::all_cases()) return 1;  // a single case proves nothing
  std::vector<int> observed;
  std::vector<double> probabilities;
  for (std::size_t state = 0; state < k_states; ++state) {
    if (target[state] == 0) {
      EXPECT_EQ(counts[state], 0);
      continue;
    }
    observed.push_back(counts[state]);
    probabilities.push_back(target[state]);
  }
  return random::chi_square_p_value(observed, probabilities);
}

template <class World>
double p_of_transition(const World& world, double beta, double keep, std::uint32_t steps) {
  return p_of(world, beta, [&](const ChainStreams& streams, std::uint64_t i, auto& sample) {
    StepStreams own = step_streams(streams, i);
    surrogate_transition(
        world, {.inverse_temperature = beta, .steps = steps, .keep = keep, .kind = 1, .scales = {}},
        own, sample, [](const StepReport&) {});
  });
}

TEST(SurrogateTransition, KeepsTheDistribution) {
  // Goal: a surrogate transition leaves the target distribution invariant, for any anchor and any
  // length of the walk. Method: draw one of six states exactly from the target, and move it once.
  // The moved states must have the target distribution, with a p-value above 1e-6.
  for (const double beta : {0.4, 1.0}) {
    for (const double keep : {0.0, 0.5, 0.9, 1.0}) {
      for (const std::uint32_t steps : {1U, 4U})
        EXPECT_GT(p_of_transition(Ring{}, beta, keep, steps), 1e-6)
            << fmt::format("beta {}, keep {}, {} steps", beta, keep, steps);
    }
  }
}

TEST(SurrogateTransition, NeedsTheAnchorsProbabilities) {
  // Goal: the test KeepsTheDistribution would detect a transition that ignores the anchors'
  // probabilities.
  if (!property::all_cases()) GTEST_SKIP() << "asks all cases together";
  for (const double keep : {0.5, 1.0})
    EXPECT_LT(p_of_transition(ForgetfulRing{}, 1, keep, 4), 1e-9) << keep;
}

TEST(SurrogateTransition, WeighsWhatTheGuessesLeave) {
  // Goal: log_surrogate_ratio() follows its formula for all terms and for zero densities.
  EXPECT_DOUBLE_EQ(log_surrogate_ratio({.inverse_temperature = 0.5,
                                        .current = 1,
                                        .current_guess = 2,
                                        .candidate = 4,
                                        .candidate_guess = 3,
                                        .log_anchor_current = -0.25,
                                        .log_anchor_candidate = -1}),
                   0.5 * ((4 - 3) - (1 - 2)) - 0.75);
  EXPECT_EQ(log_surrogate_ratio({.candidate = -k_infinity}), -k_infinity);
  EXPECT_EQ(log_surrogate_ratio({.log_anchor_candidate = -k_infinity}), -k_infinity);
  EXPECT_EQ(log_surrogate_ratio({.current = -k_infinity, .candidate = -k_infinity}), 0);
  EXPECT_EQ(log_surrogate_ratio({.current = -k_infinity, .candidate = 1}), 0);
  EXPECT_EQ(log_surrogate_ratio({.current = -k_infinity, .log_anchor_candidate = -k_infinity}), 0);
}

TEST(Iteration, KeepsTheDistribution) {
  // Goal: iterate() leaves the target distribution invariant. iterate() may use surrogate walks,
  // single steps, both or neither. Method: move exact draws once, and test their distribution.
  for (const auto& [walk, single] : {std::pair{0U, 0U}, {3U, 0U}, {0U, 3U}, {4U, 2U}}) {
    Ring ring;
    ring.steps = {.walk = walk, .single = single, .walk_kind = 1, .single_kind = 2};
    const double p =
        p_of(ring, 0.8, [&](const ChainStreams& streams, std::uint64_t i, auto& sample) {
          iterate(ring, 0.8, streams, i, sample, {}, [](const StepReport&) {});
        });
    EXPECT_GT(p, 1e-6) << walk << " " << single;
  }
}

TEST(SurrogateTransition, LeavesAStartWithoutDensity) {
  // Goal: even if a chain's start breaks a hard constraint, the chain moves, for any anchor.
  // Method: make 100 transitions from state 3, which breaks the constraint. Most transitions must
  // leave the state, and every simulated candidate must be accepted.
  for (const double keep : {0.0, 0.5, 1.0}) {
    int left = 0;
    for (std::uint64_t i = 1; i <= 100; ++i) {
      StepStreams own = step_streams({.seed = random::k_test_seed, .chain = {}, .replica = {}}, i);
      Sample<Ring> sample = evaluate(Ring{}, std::size_t{3});
      surrogate_transition(
          Ring{}, {.inverse_temperature = 1, .steps = 1, .keep = keep, .kind = 1, .scales = {}},
          own, sample, [&](const StepReport& report) {
            if (report.kind == 1) {
              EXPECT_TRUE(report.simulated && report.accepted);
            }
          });
      left += sample.state != 3 ? 1 : 0;
    }
    EXPECT_GT(left, 50) << keep;
  }
}

/// A surrogate in which a state without an anchored part is impossible.
struct StrictGuess : GuessedRing {
  double log_constraint(const Outcome& outcome) const {
    return (anchor & ~k_parts[outcome]) != 0 ? -k_infinity : GuessedRing::log_constraint(outcome);
  }
};
struct UnboundedRing : Ring {
  using Surrogate = StrictGuess;
  Surrogate surrogate(const Anchor& anchor) const {
    Surrogate surrogate;
    surrogate.anchor = anchor;
    return surrogate;
  }
};
struct BoundedRing : UnboundedRing {
  double log_constraint_at_most(const State& state) const { return k_log_constraint[state]; }
};
static_assert(BoundsConstraint<BoundedRing> && !BoundsConstraint<UnboundedRing>);

TEST(SurrogateTransition, SparesSimulationsExactly) {
  // Goal: a bound changes only which simulations run. Guesses of zero density leave the target
  // distribution invariant. Method: compare two chains. One chain has a bound that equals the
  // constraint, and the other chain has no bound. Also move exact draws, and test their
  // distribution.
  std::uint64_t spared = 0;
  std::uint64_t rejected = 0;
  for (const double keep : {0.0, 0.5, 1.0}) {
    EXPECT_GT(p_of_transition(UnboundedRing{}, 1, keep, 3), 1e-6) << keep;
    const ChainStreams streams{.seed = random::k_test_seed, .chain = {}, .replica = {}};
    Sample<BoundedRing> bounded = evaluate(BoundedRing{}, std::size_t{0});
    Sample<UnboundedRing> plain = evaluate(UnboundedRing{}, std::size_t{0});
    for (std::uint64_t i = 1; i <= 5000; ++i) {
      const SurrogateTransition transition{
          .inverse_temperature = 1, .steps = 3, .keep = keep, .kind = 1, .scales = {}};
      StepReport with;
      StepReport without;
      StepStreams one = step_streams(streams, i);
      StepStreams other = step_streams(streams, i);
      surrogate_transition(BoundedRing{}, transition, one, bounded,
                           [&](const StepReport& report) { with = report; });
      surrogate_transition(UnboundedRing{}, transition, other, plain,
                           [&](const StepReport& report) { without = report; });
      ASSERT_EQ(bounded.state, plain.state);
      ASSERT_EQ(with.accepted, without.accepted);
      if (without.kind != 1) continue;
      EXPECT_TRUE(without.simulated);
      spared += with.simulated ? 0 : 1;
      rejected += without.accepted ? 0 : 1;
    }
  }
  EXPECT_GT(spared, 500U);
  EXPECT_GE(rejected, spared);
}

TEST(Iteration, ReportsEachStepAndTransition) {
  // Goal: iterate() reports each of the surrogate's proposals. If the state changes, iterate() also
  // reports the transition. The transition has a kind of its own.
  Ring ring;
  ring.steps = {.walk = 4, .single = 3, .walk_kind = 1, .single_kind = 2};
  const ChainStreams streams{.seed = random::k_test_seed, .chain = {}, .replica = {}};
  Sample<Ring> sample = draw_afresh(ring, streams, 0);
  std::uint64_t walks = 0;
  for (std::uint64_t i = 1; i <= 4000; ++i) {
    std::array<std::uint32_t, 3> kinds{};
    const std::size_t before = sample.state;
    iterate(ring, 1, streams, i, sample, {}, [&](const StepReport& step) { ++kinds[step.kind]; });
    const bool walked = kinds[0] == 4;
    walks += walked ? 1 : 0;
    EXPECT_TRUE(walked || kinds[0] == 3);
    EXPECT_LE(kinds[1], walked ? 1U : 0U);
    EXPECT_LE(kinds[2], walked ? 0U : 3U);
    if (sample.state != before) {
      EXPECT_GT(kinds[1] + kinds[2], 0U);
    }
  }
  EXPECT_NEAR(static_cast<double>(walks), 4000 * k_walk_share, 6 * std::sqrt(4000 * 0.1875));
}

}  // namespace sleight::sampling::surrogate_transition_test
