// Tests chains in which some simulations fail. At each inverse temperature, chains must sample p_w
// p_c^beta conditioned on success (docs/SAMPLING.md).
#include <gtest/gtest.h>

#include <vector>

#include "tests/statistical/support/chi_square.h"
#include "tests/statistical/support/toy_worlds.h"
#include "worker/sampling/tempered_transition.h"

namespace sleight::statistical::failures_invariance_test {

constexpr std::uint64_t k_seed = 271828;
constexpr std::size_t k_draws = 50'000;
constexpr std::size_t k_places = RuggedRing::k_places;
/// If the kernel is right, a test fails once in 10^6 times.
constexpr double k_p_min = 1e-6;

/// The ring, in which the simulation fails at two places and the start overlaps at one place.
struct FailingRing : RuggedRing {
  static bool fails(State place) { return place == 0 || place == 6; }

  struct Outcome {
    RuggedRing::Outcome place = 0;
    plan::FailurePointer failure{};
  };
  Outcome simulate(const State& place) const {
    if (!fails(place)) return {.place = place};
    return {.place = place,
            .failure = std::make_shared<const plan::SimulationFailure>(
                plan::SimulationFailure{.kind = plan::FailureKind::search_gave_up,
                                        .message = "planted",
                                        .state = encode(place)})};
  }
  plan::FailurePointer failure(const Outcome& outcome) const { return outcome.failure; }
  bool starts_overlap(const Outcome& outcome) const { return outcome.place == 3; }
  double log_constraint(const Outcome& outcome) const {
    return RuggedRing::log_constraint(outcome.place);
  }
  bool satisfied(const Outcome& outcome) const { return RuggedRing::satisfied(outcome.place); }

  /// Returns p_beta, conditioned on success of the simulation.
  static std::vector<double> exact(double beta) {
    std::vector<double> p = RuggedRing::exact(beta);
    double sum = 0;
    for (State place = 0; place < k_places; ++place) {
      if (fails(place)) p[place] = 0;
      sum += p[place];
    }
    for (double& x : p)
      x /= sum;
    return p;
  }
};
static_assert(sampling::MayFail<FailingRing>);

sampling::ChainStreams streams_of(std::uint64_t chain) {
  return {.seed = k_seed, .chain = base::ChainId{static_cast<std::uint32_t>(chain)}, .replica = {}};
}

/// Moves exact draws by `move`, and returns the p-value of the places' counts. The null hypothesis
/// is that `move` leaves p_beta invariant.
template <class Move>
double p_value(double beta, std::uint64_t first_chain, const Move& move) {
  const FailingRing ring;
  std::vector<double> counts(k_places, 0);
  for (std::size_t i = 0; i < k_draws; ++i) {
    const sampling::ChainStreams streams = streams_of(first_chain + i);
    random::Stream start = streams.at(random::Purpose::start, 0);
    auto sample =
        sampling::evaluate(ring, RuggedRing::pick(FailingRing::exact(beta), start.uniform()));
    move(ring, streams, sample);
    ++counts[sample.state];
  }
  return chi_square_p(counts, FailingRing::exact(beta));
}

TEST(FailuresInvariance, StepsKeepTheRestrictedTarget) {
  // Goal: if steps reject candidates whose simulation fails, p_beta given success stays invariant.
  // Method: move exact draws by ten steps at several inverse temperatures, and compare the counts
  // of places with enumeration.
  for (const double beta : {0.2, 0.7, 1.0}) {
    const double p = p_value(beta, 0, [&](const auto& ring, const auto& streams, auto& sample) {
      for (std::uint64_t iteration = 1; iteration <= 10; ++iteration)
        sampling::metropolis_hastings_step(ring, beta, streams, iteration, sample);
    });
    EXPECT_GT(p, k_p_min) << "beta " << beta << ", seed " << k_seed;
  }
}

TEST(FailuresInvariance, DrawsAgainAreDrawsOfTheRestrictedPrior) {
  // Goal: if prior draws are repeated until a simulation succeeds, the last draw has the
  // distribution of the prior given success. A single draw doesn't. Method: make repeated draws and
  // compare the counts of places with enumeration. Single draws are the control.
  const auto draw = [](const auto& ring, const auto& streams, auto& sample) {
    sample = sampling::draw_afresh(ring, streams, 1);
  };
  EXPECT_GT(p_value(0, k_draws, draw), k_p_min) << "seed " << k_seed;
  const auto once = [](const auto& ring, const auto& streams, auto& sample) {
    random::Stream prior = streams.at(random::Purpose::prior, 1);
    sample = sampling::evaluate(ring, ring.draw_prior(prior));
  };
  EXPECT_LT(p_value(0, k_draws, once), k_p_min);
}

TEST(FailuresInvariance, ExcursionsKeepTheRestrictedTarget) {
  // Goal: tempered transitions leave p_beta given success invariant, although their draws and steps
  // may fail. Method: move exact draws by an excursion to the prior, and compare the counts of
  // places with enumeration.
  const std::vector<double> below{0.4, 0.1, 0};
  const double p =
      p_value(1, 2 * k_draws, [&](const auto& ring, const auto& streams, auto& sample) {
        sampling::tempered_transition(
            ring, {.inverse_temperature = 1, .below = below, .steps = 2, .proposal_scales = {}},
            streams, 1, sample);
      });
  EXPECT_GT(p, k_p_min) << "seed " << k_seed;
}

TEST(FailuresInvariance, ACandidateThatFailsIsRefusedFromAnywhere) {
  // Goal: if a chain starts at zero density, it accepts candidates by the prior alone. But the
  // chain never accepts a candidate whose simulation fails. Method: start 2,000 chains at a place
  // where p_c = 0, near places whose simulation fails. Make 20 steps of each chain.
  const FailingRing ring;
  for (std::uint64_t chain = 0; chain < 2000; ++chain) {
    auto sample = sampling::evaluate(ring, RuggedRing::State{12});
    for (std::uint64_t iteration = 1; iteration <= 20; ++iteration) {
      sampling::metropolis_hastings_step(ring, 1.0, streams_of(chain), iteration, sample);
      ASSERT_FALSE(FailingRing::fails(sample.state)) << "seed " << k_seed << ", chain " << chain;
    }
  }
}

}  // namespace sleight::statistical::failures_invariance_test
