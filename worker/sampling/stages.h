// Worlds that act in stages. For example, balls drop one after another, or dice are thrown one by
// one before they are thrown together. An outcome's probability in one blind throw may be 1e-52,
// although each stage's choice is easy.
//
// A state consists of its ground (such as a box's offsets), which no stage chooses, and of one
// choice for each stage. A prefix consists of the ground, the choices of the first stages, and the
// result of simulating these choices. To extend a prefix, the world draws the next stage's choice
// and continues the simulation. The choice's density q may depend on the prefix. The prior is the
// product
//
//   p_w(A) = p(ground) prod_i p(choice i | ground, choices before i).
//
// A potential psi_i >= 0 rates how promising a prefix of i stages is. The potential replaces p_c
// before the last stage; after the last stage p_c itself counts. So weights are exact wherever psi
// is positive. If a prefix of a state has psi = 0, the state is never reached, and islands ignore
// it.
//
// The guide is information that a world collects about itself (where lone balls land, how often a
// choice succeeds). The guide shapes q and psi; it is computed before sampling and then fixed.
//
// Invariants of a world that acts in stages
//   1. `extend` draws a choice x from q(x | guide, ground, prefix) and returns
//      log p(x | ground, prefix) - log q(x | guide, ground, prefix), or -infinity if no
//      choice is left or the simulation failed. The density q is positive wherever p and psi are
//      positive.
//   2. `draw_ground` draws a ground from p, and maybe auxiliary random numbers for `extend` (such
//      as drops that an island's particles share). Invariant 1 then holds for the mean over these
//      numbers.
//   3. `ground_given` is `draw_ground` for a given state, and `extend_as` is `extend` for a given
//      state. `ground_given` draws the auxiliary numbers on the condition that the state is a
//      particle's path. `extend_as` returns the same weights as `extend`.
//   4. Every function is a pure function of its arguments. Randomness comes from the stream.
// Source: Chopin and Papaspiliopoulos, An introduction to sequential Monte Carlo (2020), chapters
// 10 and 16. Thread safety: as for a target (target.h).
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/random/stream.h"
#include "worker/sampling/target.h"

namespace sleight::sampling {

/// Maximum number of stages. A limit exists because random numbers are addressed by (island,
/// stage).
inline constexpr std::uint32_t k_stages_max = 4096;

/// Result of extending a prefix in place.
struct Extension {
  double log_weight = 0;  ///< log p - log q of the choice; -infinity: the prefix is dead.
  SimulationReport simulation{};
};

/// A particle's alternative at a stage. Only some targets can list alternatives.
struct Alternative {
  std::size_t number = 0;
  double mass = 0;    ///< Proportional to the choice's probability. Above 0.
  double weight = 0;  ///< The model's probability density / mass.
};

template <class T>
concept ActsInStages = Target<T> && std::copyable<typename T::Prefix> &&
    requires(const T& target, const typename T::Guide& guide, const typename T::Ground& ground,
             const typename T::Prefix& prefix, typename T::Prefix& longer,
             const typename T::State& state, std::uint32_t stage, random::Stream& stream) {
  /// From 1 to k_stages_max.
  { target.stages() } -> std::same_as<std::uint32_t>;
  { target.draw_ground(guide, stream) } -> std::same_as<typename T::Ground>;
  { target.ground_given(guide, state, stream) } -> std::same_as<typename T::Ground>;
  /// Reports of the simulations that made the ground. May omit successful simulations.
  { target.simulations_of(ground) } -> std::convertible_to<std::span<const SimulationReport>>;
  { target.no_stages(guide, ground) } -> std::same_as<typename T::Prefix>;
  /// Extends a prefix of `stage` stages (from 0) by one stage.
  { target.extend(guide, ground, stage, longer, stream) } -> std::same_as<Extension>;
  /// Extends the prefix by the choice in `state`. REQUIRES: ground_given made `ground` for this
  /// state, and the prefix has the state's first `stage` stages.
  { target.extend_as(guide, ground, state, stage, longer) } -> std::same_as<Extension>;
  /// Returns log psi. Never called for empty prefixes (psi is 1) or complete prefixes.
  { target.log_potential(guide, ground, prefix) } -> std::same_as<double>;
  /// The state and the outcome of a complete prefix. REQUIRES: the prefix has all stages.
  { target.state_of(ground, prefix) } -> std::same_as<typename T::State>;
  { target.outcome_of(prefix) } -> std::same_as<typename T::Outcome>;
};

/// A target that lists its choices by sort. Choices of one sort behave alike, so particles can
/// choose together.
template <class T>
concept ListsChoices = ActsInStages<T> &&
    requires(const T& target, const typename T::Guide& guide, const typename T::Ground& ground,
             const typename T::Prefix& prefix, typename T::Prefix& longer, std::uint32_t stage,
             std::size_t number) {
  { target.sorts() } -> std::same_as<std::size_t>;
  /// Total mass of all alternatives, by sort.
  { target.masses(guide, ground, stage, prefix) } -> std::same_as<std::vector<double>>;
  /// A sort's alternatives that have positive mass.
  {
    target.alternatives(guide, ground, stage, prefix, /*sort=*/number)
    } -> std::same_as<std::vector<Alternative>>;
  /// Extends by an alternative, deterministically. The weight is 1, or 0 if the simulation failed.
  { target.take(guide, ground, stage, number, longer) } -> std::same_as<Extension>;
};

}  // namespace sleight::sampling
