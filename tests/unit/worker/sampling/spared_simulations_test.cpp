#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <concepts>

#include "tests/support/numbers.h"
#include "worker/sampling/metropolis_hastings.h"

namespace sleight::sampling::spared_simulations_test {

constexpr std::size_t k_places = 8;
constexpr std::uint64_t k_steps = 4000;
constexpr std::uint64_t k_seed = 20'260'512;

constexpr std::array<double, k_places> k_log_prior{-1.5,  -2.5,  -1.25, -3.5,
                                                   -2.25, -1.75, -4,    -k_infinity};
constexpr std::array<double, k_places> k_log_constraint{0,    2,           -k_infinity, 4,
                                                        -1.5, -k_infinity, 7,           7};
/// Upper bounds on k_log_constraint. Some bounds equal the bounded value, some are greater, and one
/// is +infinity.
constexpr std::array<double, k_places> k_at_most{0, 2.5, -0.5, 4, k_infinity, -k_infinity, 7.5, 7};

struct Plain {
  std::size_t place = 0;
};
struct Comparable {
  std::size_t place = 0;
  friend bool operator==(const Comparable&, const Comparable&) = default;
};

/// A walk over places. Kind 0 is asymmetric and reaches any place. Kind 1 proposes the current
/// state. The proposal's ratio is so low that some draws reject it.
template <class S>
struct Walk {
  using State = S;
  using Outcome = std::size_t;
  std::uint64_t* simulations = nullptr;

  State draw_prior(random::Stream& stream) const { return {stream.bits() % (k_places - 1)}; }
  double log_prior(const State& state) const { return k_log_prior[state.place]; }
  Outcome simulate(const State& state) const {
    ++*simulations;
    return state.place;
  }
  double log_constraint(Outcome outcome) const { return k_log_constraint[outcome]; }
  bool satisfied(Outcome outcome) const { return outcome == 6; }
  std::uint32_t proposal_kinds() const { return 2; }
  Proposal<State> propose(const State& state, random::Stream& stream) const {
    if (stream.uniform() < 0.2)
      return {.candidate = state, .log_q_ratio = 0.5 - stream.uniform(), .kind = 1};
    const std::size_t place = stream.bits() % k_places;
    const double log_q_ratio = 0.25 * (static_cast<double>(place) - 3);
    return {.candidate = {place}, .log_q_ratio = log_q_ratio, .kind = 0};
  }
};

template <class S>
struct BoundedWalk : Walk<S> {
  double log_constraint_at_most(const S& state) const { return k_at_most[state.place]; }
};

static_assert(Target<Walk<Plain>> && !BoundsConstraint<Walk<Plain>>);
static_assert(BoundsConstraint<BoundedWalk<Plain>>);
static_assert(!std::equality_comparable<Plain> && std::equality_comparable<Comparable>);

constexpr std::array<double, 4> k_betas{0, 0.125, 0.7, 1};

ChainStreams streams_of(std::uint32_t chain) {
  return {.seed = k_seed, .chain = base::ChainId{chain}, .replica = base::ReplicaId{0}};
}

/// Reference: a step of Algorithm 2.1 that always simulates.
template <class S>
StepReport plain_step(const Walk<S>& target, double beta, const ChainStreams& streams,
                      std::uint64_t step, Sample<Walk<S>>& current) {
  random::Stream stream = streams.at(random::Purpose::proposal, step);
  const Proposal<S> proposal = target.propose(current.state, stream);
  const Sample<Walk<S>> candidate = evaluate(target, proposal.candidate);
  const double log_u = math::log(streams.at(random::Purpose::acceptance, step).uniform());
  const double ratio =
      log_acceptance_ratio(current.log_prior, current.log_constraint, candidate.log_prior,
                           candidate.log_constraint, beta, proposal.log_q_ratio);
  const bool accepted = log_u < ratio;
  if (accepted) current = candidate;
  return {.kind = proposal.kind, .accepted = accepted, .simulated = true};
}

struct Tally {
  std::uint64_t simulated = 0, accepted = 0, same = 0, same_accepted = 0, out_of_zero = 0;
};

/// Expects that a chain equals the reference. `expected` returns whether a step needs a simulation.
template <class T, class Expected>
Tally compare(double beta, std::uint32_t chain, const Expected& expected) {
  using S = typename T::State;
  std::uint64_t simulations = 0;
  std::uint64_t reference_simulations = 0;
  T target;
  target.simulations = &simulations;
  const Walk<S> reference{&reference_simulations};
  const ChainStreams streams = streams_of(chain);
  Sample<T> sample = draw_afresh(target, streams, 0);
  Sample<Walk<S>> plain = draw_afresh(reference, streams, 0);
  Tally tally;
  for (std::uint64_t step = 1; step <= k_steps; ++step) {
    const std::uint64_t before = simulations;
    const bool from_zero = plain.log_constraint == -k_infinity;
    const Sample<Walk<S>> from = plain;
    const StepReport report = metropolis_hastings_step(target, beta, streams, step, sample);
    const StepReport whole = plain_step(reference, beta, streams, step, plain);
    EXPECT_EQ(report.kind, whole.kind) << step;
    EXPECT_EQ(report.accepted, whole.accepted) << step;
    EXPECT_EQ(sample.state.place, plain.state.place) << step;
    EXPECT_EQ(sample.outcome, plain.outcome) << step;
    EXPECT_EQ(sample.log_prior, plain.log_prior) << step;
    EXPECT_EQ(sample.log_constraint, plain.log_constraint) << step;
    EXPECT_EQ(simulations - before, report.simulated ? 1U : 0U) << step;
    random::Stream stream = streams.at(random::Purpose::proposal, step);
    const Proposal<S> proposal = reference.propose(from.state, stream);
    const bool same = proposal.candidate.place == from.state.place;
    EXPECT_EQ(report.simulated, expected(step, from, proposal, whole)) << step;
    if (::testing::Test::HasFailure()) return tally;
    tally.simulated += report.simulated ? 1 : 0;
    tally.accepted += report.accepted ? 1 : 0;
    tally.same += same ? 1 : 0;
    tally.same_accepted += same && report.accepted ? 1 : 0;
    tally.out_of_zero += from_zero && report.accepted && !same ? 1 : 0;
  }
  EXPECT_EQ(reference_simulations, k_steps + 1);
  EXPECT_EQ(simulations, tally.simulated + 1);
  return tally;
}

template <class S>
bool has_a_chance(double beta, std::uint64_t step, std::uint32_t chain, const Sample<Walk<S>>& from,
                  const Proposal<S>& proposal) {
  const std::size_t place = proposal.candidate.place;
  const double u = streams_of(chain).at(random::Purpose::acceptance, step).uniform();
  const double prior = k_log_prior[place] - from.log_prior + proposal.log_q_ratio;
  if (beta == 0 || from.log_constraint == -k_infinity) return u < std::exp(prior);
  return u < std::exp(prior + beta * (k_at_most[place] - from.log_constraint));
}

TEST(SparedSimulations, ATargetThatKnowsNothingSimulatesAll) {
  // Goal: if a target has no operator== and no bound, a chain skips no simulation, even for a
  // candidate without prior density. Method: compare chains at four inverse temperatures with the
  // reference.
  for (const double beta : k_betas) {
    const Tally tally =
        compare<Walk<Plain>>(beta, 1, [](auto, const auto&, const auto&, auto) { return true; });
    EXPECT_EQ(tally.simulated, k_steps);
  }
}

TEST(SparedSimulations, ACandidateThatIsTheCurrentStateIsNotSimulated) {
  // Goal: operator== doesn't change the chain. A candidate that equals the current state needs no
  // simulation, but its ratio still decides whether it is accepted. Method: compare chains with the
  // reference, including steps from states of zero density.
  std::uint64_t out_of_zero = 0;
  for (const double beta : k_betas) {
    for (std::uint32_t chain = 0; chain < 6; ++chain) {
      const Tally tally = compare<Walk<Comparable>>(
          beta, chain, [](auto, const auto& from, const auto& proposal, auto) {
            return !(proposal.candidate == from.state);
          });
      EXPECT_EQ(tally.simulated, k_steps - tally.same);
      EXPECT_GT(tally.same, k_steps / 5);
      // Some ratios are below 1, and not all of these are accepted.
      EXPECT_GT(tally.same_accepted, tally.same / 2);
      EXPECT_LT(tally.same_accepted, tally.same);
      out_of_zero += tally.out_of_zero;
    }
  }
  EXPECT_GT(out_of_zero, 500U);
}

TEST(SparedSimulations, ACandidateThatTheBoundRejectsIsNotSimulated) {
  // Goal: a bound on the constraint doesn't change the chain. The chain simulates a candidate
  // exactly if it would accept a candidate whose constraint density equals the bound. At beta 0,
  // and from states of zero density, the chain simulates exactly the accepted candidates. Method:
  // compare chains with the reference. Compute the expected decision from probabilities instead of
  // logs.
  for (const double beta : k_betas) {
    std::uint64_t simulated = 0;
    std::uint64_t accepted = 0;
    for (std::uint32_t chain = 0; chain < 6; ++chain) {
      const Tally tally = compare<BoundedWalk<Plain>>(
          beta, chain, [&](auto step, const auto& from, const auto& proposal, const auto& whole) {
            const bool chance = has_a_chance(beta, step, chain, from, proposal);
            if (beta == 0 || from.log_constraint == -k_infinity) {
              EXPECT_EQ(chance, whole.accepted);
            }
            return chance;
          });
      EXPECT_LT(tally.simulated, k_steps * 9 / 10);
      simulated += tally.simulated;
      accepted += tally.accepted;
    }
    if (beta == 0) {
      EXPECT_EQ(simulated, accepted);
    } else {
      EXPECT_GT(simulated, accepted);
    }
  }
}

}  // namespace sleight::sampling::spared_simulations_test
