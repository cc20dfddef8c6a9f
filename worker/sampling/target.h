// A sampler's entire interface to a world. The interface has a prior, a simulation, a constraint on
// the simulation's outcome, and a proposal.
//
// The sampled distribution p_beta(A) is proportional to p_w(A) p_c(A)^beta (thesis equation 2.1 at
// beta = 1). p_w is the world model over the random variables (State). p_c judges only the
// simulation's result (Outcome).
//
// Invariants of a target
//   1. `draw_prior` is exact: its density is exp(log_prior), normalised.
//   2. The `log_q_ratio` of `propose` is log q(current|candidate) - log q(candidate|current), so
//      Algorithm 2.1's acceptance is right for the mixture of all kinds.
//   3. Every function is a pure function of its arguments. All randomness comes from the stream.
// Thread safety: const functions may be called from several threads at once.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/plan/failure.h"
#include "common/random/stream.h"

namespace sleight::sampling {

template <class State>
struct Proposal {
  State candidate;
  double log_q_ratio = 0;  ///< log q(current|candidate) - log q(candidate|current).
  std::uint32_t kind = 0;  ///< The target's kind of proposal.
  /// If set, `log_q_ratio` is an upper bound, and the ratio depends on the outcome
  /// (ProposesByOutcome).
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
  { target.proposal_kinds() } -> std::convertible_to<std::uint32_t>;
};

/// A target that bounds log_constraint from above without a simulation (early rejection).
template <class T>
concept BoundsConstraint = Target<T> && requires(const T& target, const typename T::State& state) {
  { target.log_constraint_at_most(state) } -> std::same_as<double>;
};

/// A target whose simulation may fail (common/plan/failure.h). A failed state is never a sample.
/// In a failed state's outcome, `log_constraint` and `satisfied` mean nothing. If bodies overlap at
/// the start, p_c is 0.
template <class T>
concept MayFail = Target<T> && requires(const T& target, const typename T::Outcome& outcome) {
  { target.failure(outcome) } -> std::same_as<plan::FailurePointer>;
  { target.starts_overlap(outcome) } -> std::same_as<bool>;
};

/// A surrogate whose failed simulations still yield guesses. Failures are reported, but don't
/// reject a candidate.
template <class T>
concept GuessesOnFailure = MayFail<T> && T::k_guesses_on_failure;

/// Facts about a simulation other than the outcome.
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

/// Returns whether a failed simulation excludes the state from sampling.
template <Target T>
bool is_refused(const SimulationReport& report) {
  return report.failure != nullptr && !GuessesOnFailure<T>;
}

/// A target with tunable proposals. `scales` has a factor for each kind, or is empty if all factors
/// are 1. A kind without a scale ignores its factor. Proposals must be correct for any constant
/// factors.
template <class T>
concept ScalesProposals = Target<T> && requires(const T& target) {
  { target.has_scale(std::uint32_t{}) } -> std::same_as<bool>;
};

/// A target whose proposals also use the current outcome. If a proposal's ratio depends on the
/// candidate's outcome, `ratio_waits` is set, and `log_q_ratio` is called after the simulation.
template <class T>
concept ProposesByOutcome = ScalesProposals<T> &&
    requires(const T& target, const typename T::State& state, const typename T::Outcome& outcome,
             const Proposal<typename T::State>& proposal, std::span<const double> scales,
             random::Stream& stream) {
  { target.propose(state, outcome, scales, stream) } -> std::same_as<Proposal<typename T::State>>;
  { target.log_q_ratio(state, outcome, proposal, outcome) } -> std::same_as<double>;
};

/// A target that can derive a candidate's outcome from the previous state's outcome. To derive it
/// is cheaper than `simulate` and has the same result.
template <class T>
concept SimulatesChanges = Target<T> &&
    requires(const T& target, const typename T::State& state, const typename T::Outcome& outcome) {
  { target.simulate_from(state, state, outcome) } -> std::same_as<typename T::Outcome>;
};

/// The surrogate's steps in one iteration (surrogate_transition.h). The steps are counted under
/// `walk_kind` and `single_kind`.
struct SurrogateSteps {
  std::uint32_t walk = 0;    ///< Steps of a walk without anchor; 0: no walks.
  std::uint32_t single = 0;  ///< Number of one-step transitions.
  std::uint32_t walk_kind = 0;
  std::uint32_t single_kind = 0;
};

/// A target with a surrogate: another target over the same states, with the same p_w. The
/// surrogate's simulation is much cheaper and predicts most of an outcome. `Anchor{}` anchors
/// nothing. `simulate_from` accepts outcomes made with another anchor. States are
/// equality-comparable.
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

/// The surrogate's outcome for a sample's state, once computed.
struct NoSurrogate {};
template <class T>
struct SurrogateOutcome {
  using type = NoSurrogate;
};
template <HasSurrogate T>
struct SurrogateOutcome<T> {
  using type = std::optional<typename T::Surrogate::Outcome>;
};

/// A state and everything that is computed from it. `log_prior` and `log_constraint` always belong
/// to this state, so no stale density survives an acceptance.
template <Target T>
struct Sample {
  typename T::State state;
  typename T::Outcome outcome;
  double log_prior = 0;
  double log_constraint = 0;
  [[no_unique_address]] typename SurrogateOutcome<T>::type surrogate{};
};

template <Target T>
typename T::Outcome simulate_from(const T& target, const typename T::State& candidate,
                                  const Sample<T>& from) {
  if constexpr (SimulatesChanges<T>) {
    return target.simulate_from(candidate, from.state, from.outcome);
  } else {
    return target.simulate(candidate);
  }
}

/// Proposes a candidate by the target's function for this: `propose(state, outcome, scales,
/// stream)` if the target is a ProposesByOutcome, `propose(state, scales, stream)` if it is another
/// ScalesProposals, otherwise `propose(state, stream)`.
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

/// Returns the nth prior draw stored beside a run's samples. The draw is the same in every run.
template <Target T>
typename T::State nth_prior_draw(const T& target, std::uint64_t nth) {
  random::Stream stream({.purpose = random::Purpose::prior_draw}, nth);
  return target.draw_prior(stream);
}

/// Returns log p_w of `count` blind throws, which `draw` makes for comparison with found states.
/// Every call returns the same values.
template <Target T, class Draw>
std::vector<double> log_priors_of_throws(const T& target, std::size_t count, const Draw& draw) {
  std::vector<double> all;
  for (std::uint64_t nth = 0; nth < count; ++nth) {
    random::Stream stream({.purpose = random::Purpose::blind_throw}, nth);
    all.push_back(target.log_prior(draw(stream)));
  }
  return all;
}

/// Returns log p_w + beta log p_c, with p_c^0 = 1 even if p_c = 0.
inline double tempered_log_density(double log_prior, double log_constraint,
                                   double inverse_temperature) {
  if (inverse_temperature == 0) return log_prior;
  return log_prior + inverse_temperature * log_constraint;
}

}  // namespace sleight::sampling
