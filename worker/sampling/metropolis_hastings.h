// Metropolis-Hastings: Algorithm 2.1 of the thesis. Target and inverse temperature are arbitrary.
//
// Random numbers are addressed by (seed, chain, replica, purpose, iteration), so an iteration is a
// pure function of the state before it. Proposal and acceptance use separate streams, so the count
// of random numbers in a proposal affects nothing else.
//
// Simulations dominate the cost, so the step skips a simulation if its effect is known: if the
// candidate equals the current state, or if the candidate would be rejected even at its greatest
// possible constraint density (BoundsConstraint). Early rejection is exact, because the acceptance
// number is drawn first and the ratio is monotone in that density, even in rounded arithmetic.
//
// A candidate whose simulation fails is always rejected, so the chain samples the target
// conditioned on success of the simulation.
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "common/base/error.h"
#include "common/math/elementary.h"
#include "common/random/stream.h"
#include "worker/sampling/target.h"

namespace sleight::sampling {

/// The address of a chain's random numbers. A stream's address also has a purpose and an iteration.
struct ChainStreams {
  std::uint64_t seed = 0;
  base::ChainId chain;
  base::ReplicaId replica;

  random::Stream at(random::Purpose purpose, std::uint64_t iteration) const {
    return random::Stream({.seed = seed, .chain = chain, .replica = replica, .purpose = purpose},
                          iteration);
  }
};

struct StepReport {
  std::uint32_t kind = 0;  ///< Kind of the proposal.
  bool accepted = false;
  bool simulated = false;  ///< Whether the decision needed a simulation.
  SimulationReport simulation{};
};

/// Maximum number of consecutive failed draws from the prior.
inline constexpr std::uint32_t k_draws_max = 1000;

struct TellNobody {
  void operator()(const SimulationReport& /*report*/) const {}
};

/// Draws from the prior until a simulation succeeds. A replica's start (lines 1 and 2 of
/// Algorithm 2.1) and a scan at inverse temperature 0 use this draw. Repeated draws use the next
/// numbers of the same stream, so the result is exactly a draw from the prior conditioned on
/// success. Calls `told` for each simulation. Throws base::Error after k_draws_max consecutive
/// failures. REQUIRES: each scan of a replica at most once.
template <Target T, class Told = TellNobody>
Sample<T> draw_afresh(const T& target, const ChainStreams& streams, std::uint64_t scan,
                      const Told& told = {}) {
  random::Stream prior = streams.at(random::Purpose::prior, scan);
  SimulationReport report;
  for (std::uint32_t draw = 0; draw < k_draws_max; ++draw) {
    Sample<T> sample = evaluate(target, target.draw_prior(prior));
    report = report_of(target, sample.outcome);
    told(report);
    if (!is_refused<T>(report)) return sample;
  }
  throw base::Error(base::ExitCode::simulation_failed,
                    "all " + std::to_string(k_draws_max) +
                        " draws from the prior failed in the simulator; the last failure: " +
                        report.failure->message);
}

/// Returns log of p(A_c) q(A_i|A_c) / (p(A_i) q(A_c|A_i)), line 7. A candidate of zero density is
/// never accepted. If the current state has zero density (a start that breaks a hard constraint),
/// only the prior counts, so the chain moves until a state has positive density.
inline double log_acceptance_ratio(double current_log_prior, double current_log_constraint,
                                   double candidate_log_prior, double candidate_log_constraint,
                                   double inverse_temperature, double log_q_ratio) {
  constexpr double k_zero_density = -std::numeric_limits<double>::infinity();
  const double current =
      tempered_log_density(current_log_prior, current_log_constraint, inverse_temperature);
  const double candidate =
      tempered_log_density(candidate_log_prior, candidate_log_constraint, inverse_temperature);
  if (current == k_zero_density) return candidate_log_prior - current_log_prior + log_q_ratio;
  return candidate - current + log_q_ratio;
}

struct StepStreams {
  random::Stream proposal;
  random::Stream acceptance;
};

inline StepStreams step_streams(const ChainStreams& streams, std::uint64_t iteration) {
  return {.proposal = streams.at(random::Purpose::proposal, iteration),
          .acceptance = streams.at(random::Purpose::acceptance, iteration)};
}

/// Makes one iteration: lines 4 to 10 of Algorithm 2.1. `scales`: by kind (ScalesProposals).
template <Target T>
StepReport metropolis_hastings_step(const T& target, double inverse_temperature,
                                    StepStreams& streams, Sample<T>& current,
                                    std::span<const double> scales = {}) {
  // Propose a candidate from the current state.
  auto proposal = propose_from(target, current, scales, streams.proposal);

  const double log_u = math::log(streams.acceptance.uniform());
  const auto accepts = [&](double log_prior, double log_constraint) {
    return log_u < log_acceptance_ratio(current.log_prior, current.log_constraint, log_prior,
                                        log_constraint, inverse_temperature, proposal.log_q_ratio);
  };

  // Skip the simulation if its effect is known.
  if constexpr (std::equality_comparable<typename T::State>) {
    if (proposal.candidate == current.state) {
      return {.kind = proposal.kind,
              .accepted = accepts(current.log_prior, current.log_constraint)};
    }
  }
  const double log_prior = target.log_prior(proposal.candidate);
  if constexpr (BoundsConstraint<T>) {
    if (!accepts(log_prior, target.log_constraint_at_most(proposal.candidate)))
      return {.kind = proposal.kind, .accepted = false};
  }

  // Simulate the candidate, and accept it with probability min(1, ratio).
  typename T::Outcome outcome = simulate_from(target, proposal.candidate, current);
  StepReport report{
      .kind = proposal.kind, .simulated = true, .simulation = report_of(target, outcome)};
  if (is_refused<T>(report.simulation)) return report;
  const double log_constraint = target.log_constraint(outcome);
  if constexpr (ProposesByOutcome<T>) {
    if (proposal.ratio_waits)
      proposal.log_q_ratio = target.log_q_ratio(current.state, current.outcome, proposal, outcome);
  }
  report.accepted = accepts(log_prior, log_constraint);
  if (report.accepted)
    current = {std::move(proposal.candidate), std::move(outcome), log_prior, log_constraint};
  return report;
}

/// Like the overload above, but uses the streams of `iteration`. REQUIRES: each iteration of a
/// replica is used at most once.
template <Target T>
StepReport metropolis_hastings_step(const T& target, double inverse_temperature,
                                    const ChainStreams& streams, std::uint64_t iteration,
                                    Sample<T>& current, std::span<const double> scales = {}) {
  StepStreams own = step_streams(streams, iteration);
  return metropolis_hastings_step(target, inverse_temperature, own, current, scales);
}

}  // namespace sleight::sampling
