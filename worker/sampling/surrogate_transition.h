// Surrogate transitions (Liu 2001, Monte Carlo Strategies in Scientific Computing, 9.4.3; of one
// step, the delayed acceptance of Christen and Fox 2005, Markov chain Monte Carlo using an
// approximation): some steps of a cheap target, one simulation.
//
// Idea. A surrogate (target.h) guesses l = log p_c of a state as l*, for far less than a
// simulation. From the present state x some Metropolis-Hastings steps sample p_w p_c*^beta; where
// they end, y, is the candidate. It is simulated, and accepted with probability min(1, ratio),
//
//   log ratio = beta ((l(y) - l*(y)) - (l(x) - l*(x))):
//
// the steps are reversible, so the ways there and back weigh as much as p_w p_c*^beta of their
// ends, and only what the surrogate got wrong is left. Candidates that fail by its guess already
// cost no simulation, and a walk of several steps makes several changes for one.
//
// Anchors. What the surrogate got wrong of x it would have the steps "mend", in vain: x has it
// right already. So what it knows of x may be put into it: of the parts of x that only the
// simulation gets right (F(x), say balls that reach their place because others push them) each is
// kept with a probability, and the surrogate takes the kept ones, the anchor A, for granted as long
// as the steps leave them alone. The way back must have the same anchor, so with P the probability
// to draw it
//
//   log ratio += log P(A | y) - log P(A | x),
//
// which is -infinity where A is not of F(y). Nothing kept is the surrogate by itself; all kept is
// the best guess, but F never changes; so transitions of one step keep all, or each second one.
//
// What exactness rests on: the surrogate has the target's p_w; l*(x) > -infinity where l(x) is,
// with any anchor that x may have; and what an anchor is drawn from, and its probability, of the
// surrogate's outcome, is the same whatever anchor that outcome was made with.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "common/math/elementary.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/target.h"

namespace sleight::sampling {

/// Iterations that are a walk, where there are such.
inline constexpr double k_walk_share = 0.25;
/// Transitions of one step that keep all of F; the others keep each part with k_keep.
inline constexpr double k_keep_all_share = 0.7;
inline constexpr double k_keep = 0.5;

/// What the guesses leave for the simulation to say.
struct SurrogateMove {
  double inverse_temperature = 1;
  double current = 0;        ///< l(x)
  double current_guess = 0;  ///< l*(x)
  double candidate = 0;
  double candidate_guess = 0;
  double log_anchor_current = 0;  ///< log P(A | x)
  double log_anchor_candidate = 0;
};
inline double log_surrogate_ratio(const SurrogateMove& move) {
  constexpr double k_zero_density = -std::numeric_limits<double>::infinity();
  // Out of a start that breaks a hard constraint everything is taken.
  if (move.current == k_zero_density) return 0;
  if (move.candidate == k_zero_density) return k_zero_density;
  return move.inverse_temperature *
             ((move.candidate - move.candidate_guess) - (move.current - move.current_guess)) +
         move.log_anchor_candidate - move.log_anchor_current;
}

/// How one transition is made.
struct SurrogateTransition {
  double inverse_temperature = 1;
  std::uint32_t steps = 1;
  double keep = 0;                 ///< probability that a part of F is anchored
  std::uint32_t kind = 0;          ///< that it is counted as
  std::span<const double> scales;  ///< of proposals, by kind
};

/// Replaces `current` or keeps it. `count` is told each step's report, accepted or not by the guess
/// and not simulated, and the transition's if it led anywhere. REQUIRES: an inverse temperature
/// above 0.
template <HasSurrogate T, class Count>
void surrogate_transition(const T& target, const SurrogateTransition& transition,
                          StepStreams& streams, Sample<T>& current, const Count& count) {
  using Surrogate = typename T::Surrogate;
  using Anchor = typename T::Anchor;
  if (!current.surrogate) current.surrogate = target.surrogate(Anchor{}).simulate(current.state);
  const Anchor anchor = target.draw_anchor(current.state, current.outcome, *current.surrogate,
                                           transition.keep, streams.proposal);
  const Surrogate surrogate = target.surrogate(anchor);

  // The surrogate's steps.
  auto guessed = surrogate.simulate_from(current.state, current.state, *current.surrogate);
  const double guess = surrogate.log_constraint(guessed);
  Sample<Surrogate> walk{current.state, std::move(guessed), current.log_prior, guess};
  for (std::uint32_t step = 0; step < transition.steps; ++step) {
    StepReport guessed_step = metropolis_hastings_step(surrogate, transition.inverse_temperature,
                                                       streams, walk, transition.scales);
    guessed_step.simulated = false;  // by the surrogate alone; its failures count
    count(guessed_step);
  }

  // Simulate where they end, and accept it with probability min(1, ratio).
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

/// One iteration as the target wants it: a walk of its surrogate, or several single steps of that;
/// a step of Algorithm 2.1 if it wants neither. REQUIRES: an iteration once per replica.
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
