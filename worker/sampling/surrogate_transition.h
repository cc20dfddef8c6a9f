// Surrogate transitions (Liu 2001, Monte Carlo Strategies in Scientific Computing, 9.4.3): several
// steps on a cheap target and then one simulation. If there is one step, this is the delayed
// acceptance of Christen and Fox (2005, Markov chain Monte Carlo using an approximation).
//
// Idea. For a state's l = log p_c, a surrogate (target.h) guesses l*. The guess is far cheaper than
// a simulation. From the current state x, Metropolis-Hastings steps on p_w p_c*^beta lead to a
// candidate y. The candidate is simulated, and accepted with probability min(1, ratio),
//
//   log ratio = beta ((l(y) - l*(y)) - (l(x) - l*(x))).
//
// The steps are reversible, so only the surrogate's error remains in the ratio. If the surrogate
// rejects a candidate, no simulation is needed. A walk of several steps costs only one simulation.
//
// Anchors. If the surrogate is wrong about x, its steps would try to "mend" parts of x that are
// already right. Let F(x) be the parts of x that only the simulation gets right. An example of such
// a part is a ball that reaches its place because other balls push it. Each part is kept with some
// probability. The kept parts are the anchor A. The surrogate treats these parts as right as long
// as its steps don't change them. The reverse move must have the same anchor. If P is an anchor's
// probability, then
//
//   log ratio += log P(A | y) - log P(A | x),
//
// which is -infinity if A is not part of F(y). If nothing is kept, the surrogate works unaided. If
// all parts are kept, the guess is best, but F never changes. So transitions of one step keep
// either all parts, or each part with probability 1/2.
//
// Exactness requires three things. The surrogate has the target's p_w. If l(x) > -infinity, then
// l*(x) > -infinity for each anchor that x may have. F and P are computed from the surrogate's
// outcome, but don't depend on that outcome's anchor.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "common/math/elementary.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/target.h"

namespace sleight::sampling {

/// Share of iterations that are walks, if the target has walks.
inline constexpr double k_walk_share = 0.25;
/// Share of one-step transitions that keep all of F. Other one-step transitions keep each part with
/// probability k_keep.
inline constexpr double k_keep_all_share = 0.7;
inline constexpr double k_keep = 0.5;

/// Densities and guesses from which the acceptance ratio is computed.
struct SurrogateMove {
  double inverse_temperature = 1;
  double current = 0;        ///< l(x).
  double current_guess = 0;  ///< l*(x).
  double candidate = 0;
  double candidate_guess = 0;
  double log_anchor_current = 0;  ///< log P(A | x).
  double log_anchor_candidate = 0;
};
inline double log_surrogate_ratio(const SurrogateMove& move) {
  constexpr double k_zero_density = -std::numeric_limits<double>::infinity();
  // Accept every candidate if the start breaks a hard constraint.
  if (move.current == k_zero_density) return 0;
  if (move.candidate == k_zero_density) return k_zero_density;
  return move.inverse_temperature *
             ((move.candidate - move.candidate_guess) - (move.current - move.current_guess)) +
         move.log_anchor_candidate - move.log_anchor_current;
}

struct SurrogateTransition {
  double inverse_temperature = 1;
  std::uint32_t steps = 1;
  double keep = 0;                 ///< Probability that a part of F is anchored.
  std::uint32_t kind = 0;          ///< Kind of proposal for the counts.
  std::span<const double> scales;  ///< Proposal scales by kind.
};

/// Makes one transition of `current`. Calls `count` with each surrogate step's report, which is
/// marked as not simulated. If the walk ended at another state, also calls `count` with the
/// transition's report. REQUIRES: an inverse temperature above 0.
template <HasSurrogate T, class Count>
void surrogate_transition(const T& target, const SurrogateTransition& transition,
                          StepStreams& streams, Sample<T>& current, const Count& count) {
  using Surrogate = typename T::Surrogate;
  using Anchor = typename T::Anchor;
  if (!current.surrogate) current.surrogate = target.surrogate(Anchor{}).simulate(current.state);
  const Anchor anchor = target.draw_anchor(current.state, current.outcome, *current.surrogate,
                                           transition.keep, streams.proposal);
  const Surrogate surrogate = target.surrogate(anchor);

  // Make the surrogate's steps.
  auto guessed = surrogate.simulate_from(current.state, current.state, *current.surrogate);
  const double guess = surrogate.log_constraint(guessed);
  Sample<Surrogate> walk{current.state, std::move(guessed), current.log_prior, guess};
  for (std::uint32_t step = 0; step < transition.steps; ++step) {
    StepReport guessed_step = metropolis_hastings_step(surrogate, transition.inverse_temperature,
                                                       streams, walk, transition.scales);
    guessed_step.simulated = false;  // Only the surrogate was simulated; its failures count.
    count(guessed_step);
  }

  // Simulate the end of the walk, and accept it with probability min(1, ratio).
  const double log_u = math::log(streams.acceptance.uniform());
  if (walk.state == current.state) return;
  StepReport report{.kind = transition.kind};
  SurrogateMove move{.inverse_temperature = transition.inverse_temperature,
                     .current = current.log_constraint,
                     .current_guess = guess,
                     .candidate = 0,
                     .candidate_guess = walk.log_constraint,
                     .log_anchor_current = target.log_anchor_probability(
                         anchor, current.outcome, *current.surrogate, transition.keep),
                     .log_anchor_candidate = 0};
  if constexpr (BoundsConstraint<T>) {
    move.candidate = target.log_constraint_at_most(walk.state);
    if (!(log_u < log_surrogate_ratio(move))) {
      count(report);
      return;
    }
  }
  typename T::Outcome outcome = simulate_from(target, walk.state, current);
  report.simulated = true;
  report.simulation = report_of(target, outcome);
  if (is_refused<T>(report.simulation)) {
    count(report);
    return;
  }
  move.candidate = target.log_constraint(outcome);
  move.log_anchor_candidate =
      target.log_anchor_probability(anchor, outcome, walk.outcome, transition.keep);
  report.accepted = log_u < log_surrogate_ratio(move);
  if (report.accepted) {
    current = {std::move(walk.state), std::move(outcome), walk.log_prior, move.candidate,
               std::move(walk.outcome)};
  }
  count(report);
}

/// Makes one iteration: a walk on the target's surrogate, or several one-step transitions. If no
/// surrogate step is possible, makes a step of Algorithm 2.1. REQUIRES: each iteration of a replica
/// at most once.
template <Target T, class Count>
void iterate(const T& target, double inverse_temperature, const ChainStreams& streams,
             std::uint64_t iteration, Sample<T>& current, std::span<const double> scales,
             const Count& count) {
  if constexpr (HasSurrogate<T>) {
    const SurrogateSteps steps = target.surrogate_steps(scales);
    if (inverse_temperature > 0 && (steps.walk > 0 || steps.single > 0)) {
      StepStreams own = step_streams(streams, iteration);
      SurrogateTransition transition{.inverse_temperature = inverse_temperature,
                                     .steps = steps.walk,
                                     .keep = 0,
                                     .kind = steps.walk_kind,
                                     .scales = scales};
      const bool walks = own.proposal.uniform() < k_walk_share && steps.walk > 0;
      if (walks) {
        surrogate_transition(target, transition, own, current, count);
        return;
      }
      transition.steps = 1;
      transition.kind = steps.single_kind;
      for (std::uint32_t i = 0; i < steps.single; ++i) {
        transition.keep = own.proposal.uniform() < k_keep_all_share ? 1 : k_keep;
        surrogate_transition(target, transition, own, current, count);
      }
      return;
    }
  }
  count(metropolis_hastings_step(target, inverse_temperature, streams, iteration, current, scales));
}

}  // namespace sleight::sampling
