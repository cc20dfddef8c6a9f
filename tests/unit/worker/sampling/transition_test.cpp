// Compares one Metropolis-Hastings step on five states with its exact transition matrix.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

#include "tests/support/numbers.h"
#include "tests/unit/common/random/chi_square.h"
#include "worker/sampling/metropolis_hastings.h"

namespace sleight::sampling {
namespace {

constexpr std::size_t k_states = 5;
using Row = std::array<double, k_states>;
using Matrix = std::array<Row, k_states>;

constexpr Row k_prior{0.1, 0.3, 0.2, 0.15, 0.25};
constexpr Row k_log_constraint{-0.2, -1.5, 0, -k_infinity, -0.7};
constexpr double k_clockwise = 0.7;
constexpr double k_fresh = 0.25;

/// A ring. Kind 0 steps to a neighbour, more often clockwise; kind 1 draws from the prior.
struct Ring {
  using State = std::size_t;
  using Outcome = std::size_t;

  static std::size_t pick(const Row& probabilities, double u) {
    std::size_t state = 0;
    while (state + 1 < k_states && u >= probabilities[state])
      u -= probabilities[state++];
    return state;
  }

  State draw_prior(random::Stream& stream) const { return pick(k_prior, stream.uniform()); }
  double log_prior(const State& state) const { return std::log(k_prior[state]); }
  Outcome simulate(const State& state) const { return state; }
  double log_constraint(const Outcome& outcome) const { return k_log_constraint[outcome]; }
  bool satisfied(const Outcome& outcome) const { return outcome == 2; }
  std::uint32_t proposal_kinds() const { return 2; }
  Proposal<State> propose(const State& state, random::Stream& stream) const {
    if (stream.uniform() < k_fresh) {
      const State candidate = draw_prior(stream);
      return {.candidate = candidate,
              .log_q_ratio = log_prior(state) - log_prior(candidate),
              .kind = 1};
    }
    const bool clockwise = stream.uniform() < k_clockwise;
    const double odds = std::log((1 - k_clockwise) / k_clockwise);
    return {.candidate = (state + (clockwise ? 1 : k_states - 1)) % k_states,
            .log_q_ratio = clockwise ? odds : -odds,
            .kind = 0};
  }
};
static_assert(Target<Ring>);

double density(std::size_t state, double beta) {
  const double constraint = std::exp(k_log_constraint[state]);
  return k_prior[state] * (beta == 0 ? 1 : std::pow(constraint, beta));
}

/// Algorithm 2.1's acceptance as a probability. If the current state has zero density, the
/// acceptance depends only on the prior and the proposal's ratio.
double acceptance(std::size_t from, std::size_t to, double q_ratio, double beta) {
  const double now = density(from, beta);
  if (now == 0) return std::min(1.0, k_prior[to] / k_prior[from] * q_ratio);
  return std::min(1.0, density(to, beta) / now * q_ratio);
}

Matrix exact_transitions(double beta) {
  Matrix matrix{};
  for (std::size_t from = 0; from < k_states; ++from) {
    const auto add = [&](std::size_t to, double probability, double q_ratio) {
      const double accepted = probability * acceptance(from, to, q_ratio, beta);
      matrix[from][to] += accepted;
      matrix[from][from] += probability - accepted;
    };
    const double step = 1 - k_fresh;
    add((from + 1) % k_states, step * k_clockwise, (1 - k_clockwise) / k_clockwise);
    add((from + 4) % k_states, step * (1 - k_clockwise), k_clockwise / (1 - k_clockwise));
    for (std::size_t to = 0; to < k_states; ++to)
      add(to, k_fresh * k_prior[to], k_prior[from] / k_prior[to]);
  }
  return matrix;
}

TEST(Transitions, OracleIsInDetailedBalance) {
  // Goal: the exact transition matrix leaves p_w p_c^beta invariant. The next test compares steps
  // with this matrix. Method: check that every pair of states is in detailed balance, and that each
  // row adds up to 1. If beta is above 0, no state leads to state 3, which breaks the constraint.
  for (const double beta : {0.0, 0.5, 1.0}) {
    const Matrix matrix = exact_transitions(beta);
    for (std::size_t i = 0; i < k_states; ++i) {
      EXPECT_NEAR(std::accumulate(matrix[i].begin(), matrix[i].end(), 0.0), 1, 1e-15);
      if (beta > 0 && i != 3) {
        EXPECT_EQ(matrix[i][3], 0);
      }
      for (std::size_t j = 0; j < k_states; ++j) {
        if (density(i, beta) == 0 || density(j, beta) == 0) continue;
        EXPECT_NEAR(density(i, beta) * matrix[i][j], density(j, beta) * matrix[j][i], 1e-16);
      }
    }
  }
}

TEST(Transitions, AreTheExactOnes) {
  // Goal: a step has exactly the transition probabilities of Algorithm 2.1. From a state with zero
  // density, a step has the transition probabilities of Algorithm 2.1 for the prior. Method: at
  // three inverse temperatures, make 200,000 steps from each state. Compare with the exact matrix
  // by chi-square. Impossible steps never happen.
  constexpr std::uint64_t k_steps = 200'000;
  const Ring ring;
  for (const double beta : {0.0, 0.5, 1.0}) {
    const Matrix matrix = exact_transitions(beta);
    for (std::size_t from = 0; from < k_states; ++from) {
      SCOPED_TRACE(fmt::format("beta {}, from state {}", beta, from));
      const ChainStreams streams{.seed = random::k_test_seed,
                                 .chain = base::ChainId{static_cast<std::uint32_t>(from)},
                                 .replica = base::ReplicaId{0}};
      std::array<int, k_states> counts{};
      for (std::uint64_t step = 1; step <= k_steps; ++step) {
        Sample<Ring> sample = evaluate(ring, from);
        const StepReport report = metropolis_hastings_step(ring, beta, streams, step, sample);
        ASSERT_TRUE(report.accepted || sample.state == from);
        ASSERT_EQ(sample.outcome, sample.state);
        ASSERT_EQ(sample.log_prior, ring.log_prior(sample.state));
        ASSERT_EQ(sample.log_constraint, k_log_constraint[sample.state]);
        ++counts[sample.state];
      }
      std::vector<int> possible;
      std::vector<double> probabilities;
      for (std::size_t to = 0; to < k_states; ++to) {
        if (matrix[from][to] > 0) {
          possible.push_back(counts[to]);
          probabilities.push_back(matrix[from][to]);
        } else {
          EXPECT_EQ(counts[to], 0) << to;
        }
      }
      random::expect_plausible(random::chi_square_p_value(possible, probabilities), "transitions");
    }
  }
}

TEST(Transitions, StartIsADrawFromThePrior) {
  // Goal: draw_afresh() uses a chain's own streams to draw the chain's start from the prior p_w.
  // Method: compare the starts of 100,000 chains with the prior by chi-square.
  const Ring ring;
  std::vector<int> counts(k_states, 0);
  for (std::uint32_t chain = 0; chain < 100'000; ++chain) {
    const Sample<Ring> sample = draw_afresh(
        ring,
        {.seed = random::k_test_seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}},
        0);
    ASSERT_EQ(sample.log_constraint, k_log_constraint[sample.state]);
    ++counts[sample.state];
  }
  random::expect_plausible(
      random::chi_square_p_value(counts, std::vector<double>(k_prior.begin(), k_prior.end())),
      "prior");
}

}  // namespace
}  // namespace sleight::sampling
