// What a sampler needs to know of a world, and nothing more: a prior that can be drawn from, a
// simulation, the constraint on its outcome, and a proposal.
//
// The distribution that is sampled is p_beta(A) proportional to p_w(A) p_c(A)^beta (thesis equation
// 2.1 at beta = 1). p_w is the world model over the random variables (State); p_c judges only what
// the simulation made of them (Outcome).
//
// Invariants of a target
//   1. draw_prior is exact: its density is exp(log_prior), normalised.
//   2. propose's log_q_ratio is log q(current|candidate) - log q(candidate|current), so that
//      Algorithm 2.1's acceptance is right for the mixture over all kinds.
//   3. Every function is a pure function of its arguments; all randomness comes from the stream.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "common/plan/failure.h"
#include "common/random/stream.h"

namespace sleight::sampling {

/// A candidate state, and what acceptance needs of how it came about.
template <class State>
struct Proposal {
  State candidate;
  double log_q_ratio = 0;  ///< log q(current|candidate) - log q(candidate|current)
  std::uint32_t kind = 0;  ///< which of the target's proposal kinds made it
  /// The ratio hangs on the candidate's outcome, and log_q_ratio is no less (ProposesByOutcome).
  bool ratio_waits = false;
};

template <class T>
concept Target = std::copyable<typename T::State> && std::copyable<typename T::Outcome> &&
    requires(const T& target, const typename T::State& state, const typename T::Outcome& outcome,
             random::Stream& stream) {
  { target.draw_prior(stream) } -> std::same_as<typename T::State>;
  { target.log_prior(state) } -> std::same_as<double>;
  { target.simulate(state) } -> std::same_as<typename T::Outcome>;
  { target.log_constraint(outcome) } -> std::same_as<double>;
  { target.satisfied(outcome) } -> std::same_as<bool>;
  { target.propose(state, stream) } -> std::same_as<Proposal<typename T::State>>;
  { target.proposal_kinds() } -> std::convertible_to<std::uint32_t>;
};

/// A target that knows, without a simulation, a bound that a state's log_constraint can't exceed:
/// then a candidate that couldn't be accepted even so need not be simulated.
template <class T>
concept BoundsConstraint = Target<T> && requires(const T& target, const typename T::State& state) {
  { target.log_constraint_at_most(state) } -> std::same_as<double>;
};

/// A target whose simulation may fail (common/plan/failure.h). What failed is never a sample: p_c
/// and `satisfied` of such an outcome mean nothing. Outcomes of starts that overlap are known, with
/// p_c = 0.
template <class T>
concept MayFail = Target<T> && requires(const T& target, const typename T::Outcome& outcome) {
  { target.failure(outcome) } -> std::same_as<plan::FailurePointer>;
  { target.starts_overlap(outcome) } -> std::same_as<bool>;
};

/// A surrogate that may fail guesses then, which is as right as any guess: its failures are told,
/// and refuse nothing.
template <class T>
concept GuessesOnFailure = MayFail<T> && T::k_guesses_on_failure;

/// What there is to tell of one simulation besides its outcome.
struct SimulationReport {
  bool starts_overlap = false;
  plan::FailurePointer failure{};
};

template <Target T>
SimulationReport report_of(const T& target, const typename T::Outcome& outcome) {
  if constexpr (MayFail<T>) {
    return {.starts_overlap = target.starts_overlap(outcome), .failure = target.failure(outcome)};
  } else {
    return {};
  }
}

/// Whether a simulation failed, so that its state can be no sample.
template <Target T>
bool is_refused(const SimulationReport& report) {
  return report.failure != nullptr && !GuessesOnFailure<T>;
}

/// A target some of whose proposals have a size, which can be made larger or smaller: `scales` has
/// a factor for each kind, or is empty for 1. A kind that has none ignores its factor. Proposals
/// must be right for any factors, as long as these stay the same.
template <class T>
concept ScalesProposals = Target<T> &&
    requires(const T& target, const typename T::State& state, std::span<const double> scales,
             random::Stream& stream) {
  { target.propose(state, scales, stream) } -> std::same_as<Proposal<typename T::State>>;
  { target.has_scale(std::uint32_t{}) } -> std::same_as<bool>;
};

/// A target whose proposals look at the outcome too. A proposal's ratio may then hang on the
/// candidate's outcome: it has ratio_waits, and is asked for after the simulation.
template <class T>
concept ProposesByOutcome = ScalesProposals<T> &&
    requires(const T& target, const typename T::State& state, const typename T::Outcome& outcome,
             const Proposal<typename T::State>& proposal, std::span<const double> scales,
             random::Stream& stream) {
  { target.propose(state, outcome, scales, stream) } -> std::same_as<Proposal<typename T::State>>;
  { target.log_q_ratio(state, outcome, proposal, outcome) } -> std::same_as<double>;
};

/// A target that can say what comes of a candidate from what came of the state that it was made
/// from, for less: the same as `simulate` would.
template <class T>
concept SimulatesChanges = Target<T> &&
    requires(const T& target, const typename T::State& state, const typename T::Outcome& outcome) {
  { target.simulate_from(state, state, outcome) } -> std::same_as<typename T::Outcome>;
};

/// Steps of a surrogate in one iteration (surrogate_transition.h), and the kinds of proposals that
/// transitions count as.
struct SurrogateSteps {
  std::uint32_t walk = 0;    ///< of a walk that nothing anchors; 0: no such walks
  std::uint32_t single = 0;  ///< transitions of one step each
  std::uint32_t walk_kind = 0;
  std::uint32_t single_kind = 0;
};

/// A target with a surrogate: another target over the same states, with the same p_w, whose
/// simulation costs far less and tells most of what comes of a state. What it got wrong of a state
/// may anchor it (surrogate_transition.h); an Anchor{} anchors nothing. simulate_from may be given
/// an outcome that was made with another anchor. States can be compared.
template <class T>
concept HasSurrogate = Target<T> && SimulatesChanges<typename T::Surrogate> &&
    std::same_as<typename T::State, typename T::Surrogate::State> &&
    requires(const T& target, const typename T::State& state, const typename T::Outcome& outcome,
             const typename T::Surrogate::Outcome& surrogate_outcome,
             const typename T::Anchor& anchor, double keep, std::span<const double> scales,
             random::Stream& stream) {
  { target.surrogate(anchor) } -> std::same_as<typename T::Surrogate>;
  {
    target.draw_anchor(state, outcome, surrogate_outcome, keep, stream)
    } -> std::same_as<typename T::Anchor>;
  {
    target.log_anchor_probability(anchor, outcome, surrogate_outcome, keep)
    } -> std::same_as<double>;
  { target.surrogate_steps(scales) } -> std::same_as<SurrogateSteps>;
};

/// What the surrogate made of a sample's state, once that is known; nothing for other targets.
struct NoSurrogate {};
template <class T>
struct SurrogateOutcome {
  using type = NoSurrogate;
};
template <HasSurrogate T>
struct SurrogateOutcome<T> {
  using type = std::optional<typename T::Surrogate::Outcome>;
};

/// A state together with everything that was computed from it. log_prior and log_constraint always
/// belong to this state: they travel together, so that no old density outlives an acceptance.
template <Target T>
struct Sample {
  typename T::State state;
  typename T::Outcome outcome;
  double log_prior = 0;
  double log_constraint = 0;
  [[no_unique_address]] typename SurrogateOutcome<T>::type surrogate{};
};

/// What comes of a candidate that was made from a sample.
template <Target T>
typename T::Outcome simulate_from(const T& target, const typename T::State& candidate,
                                  const Sample<T>& from) {
  if constexpr (SimulatesChanges<T>) {
    return target.simulate_from(candidate, from.state, from.outcome);
  } else {
    return target.simulate(candidate);
  }
}

/// A candidate of the target's proposals, of such sizes if it has sizes.
template <Target T>
Proposal<typename T::State> propose_from(const T& target, const Sample<T>& current,
                                         std::span<const double> scales, random::Stream& stream) {
  if constexpr (ProposesByOutcome<T>) {
    return target.propose(current.state, current.outcome, scales, stream);
  } else if constexpr (ScalesProposals<T>) {
    return target.propose(current.state, scales, stream);
  } else {
    return target.propose(current.state, stream);
  }
}

/// Simulates a state and evaluates both densities.
template <Target T>
Sample<T> evaluate(const T& target, typename T::State state) {
  const double log_prior = target.log_prior(state);
  typename T::Outcome outcome = target.simulate(state);
  const double log_constraint = target.log_constraint(outcome);
  return {std::move(state), std::move(outcome), log_prior, log_constraint};
}

/// The nth of the draws from the prior that stand beside a run's samples: the same in every run.
template <Target T>
typename T::State nth_prior_draw(const T& target, std::uint64_t nth) {
  random::Stream stream({.purpose = random::Purpose::prior_draw}, nth);
  return target.draw_prior(stream);
}

/// log p_w + beta log p_c, with p_c^0 = 1 also where p_c = 0.
inline double tempered_log_density(double log_prior, double log_constraint,
                                   double inverse_temperature) {
  if (inverse_temperature == 0) return log_prior;
  return log_prior + inverse_temperature * log_constraint;
}

}  // namespace sleight::sampling
