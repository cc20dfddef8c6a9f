// Worlds that act in stages: balls that drop one after another, dice that are thrown one by one
// before they are thrown together. What one blind throw does with a probability of 1e-52 is, stage
// by stage, a chain of easy choices.
//
// A state is made of its ground, which no stage chooses (a box's offsets), and of one choice for
// each stage. A prefix is the ground with the choices of the first stages, and what came of them.
// To extend a prefix is to draw the next stage's choice from a density q of the world's own, which
// may look at the prefix, and to simulate what comes of it, from what came of the prefix before.
//
//   p_w(A) = p(ground) prod_i p(choice i | ground, choices before i)
//
// A potential psi_i >= 0 says how promising a prefix of i stages is. It takes the place of p_c
// until the last stage, after which p_c itself counts: whatever psi is, weights stay exact where
// psi is positive. States one of whose prefixes has psi = 0 are never reached (islands say nothing
// of them).
//
// Guide. What a world has learnt of itself (where lone balls land, how often a choice succeeds)
// shapes q and psi. It is learnt before anything counts and then stays as it is.
//
// Invariants of a world that acts in stages
//   1. extend draws a choice x from q(x | guide, ground, prefix) and returns
//      log p(x | ground, prefix) - log q(x | guide, ground, prefix), for every x with p > 0 and
//      psi > 0: q > 0 there. -infinity says that no choice is left, or that the simulation failed.
//   2. draw_ground draws a ground from p. With it may come auxiliary numbers that extend uses (a
//   pool
//      of drops that an island's particles share). Invariant 1 then holds on average over these:
//      the mean of the product of weights, over numbers and choices, is what it would be without
//      them.
//   3. ground_given and extend_as are draw_ground and extend given the state. The numbers are drawn
//      given that the state is the path of one particle; weights are those of extend.
//   4. Everything is a pure function of its arguments; randomness comes from the stream.
// Source: N. Chopin, O. Papaspiliopoulos, An introduction to sequential Monte Carlo (2020),
// chapters 10 and 16. Thread safety: as of a target (target.h).
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/random/stream.h"
#include "worker/sampling/target.h"

namespace sleight::sampling {

/// So many stages at most: random numbers are addressed by (island, stage).
inline constexpr std::uint32_t k_stages_max = 4096;

/// What came of extending a prefix, which is the longer one afterwards.
struct Extension {
  double log_weight = 0;  ///< log p - log q of the choice; -infinity: the prefix is dead
  SimulationReport simulation{};
};

/// One thing that a particle may choose at a stage, where all of these can be listed.
struct Alternative {
  std::size_t number = 0;
  double mass = 0;    ///< above 0: it is chosen in proportion to it; all need not add up to 1
  double weight = 0;  ///< its probability density under the model over its mass
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
  /// Simulations that the ground took, those that failed at least.
  { target.simulations_of(ground) } -> std::convertible_to<std::span<const SimulationReport>>;
  /// The prefix without stages.
  { target.no_stages(guide, ground) } -> std::same_as<typename T::Prefix>;
  /// Makes a prefix of `stage` stages, from 0, longer by one.
  { target.extend(guide, ground, stage, longer, stream) } -> std::same_as<Extension>;
  /// By the state's own choice. REQUIRES: `ground` is from ground_given of this state, and the
  /// prefix is the state's first `stage` stages.
  { target.extend_as(guide, ground, state, stage, longer) } -> std::same_as<Extension>;
  /// log psi of a prefix. Not asked for of no stages and of all stages: these have psi = 1 and p_c.
  { target.log_potential(guide, ground, prefix) } -> std::same_as<double>;
  /// The state and what it came to. REQUIRES: the prefix has all stages.
  { target.state_of(ground, prefix) } -> std::same_as<typename T::State>;
  { target.outcome_of(prefix) } -> std::same_as<typename T::Outcome>;
};

/// Its choices can be listed, by sorts that fare alike; then particles may choose together
/// (Islands::joint).
template <class T>
concept ListsChoices = ActsInStages<T> &&
    requires(const T& target, const typename T::Guide& guide, const typename T::Ground& ground,
             const typename T::Prefix& prefix, typename T::Prefix& longer, std::uint32_t stage,
             std::size_t number) {
  { target.sorts() } -> std::same_as<std::size_t>;
  /// By sort: of all its alternatives together.
  { target.masses(guide, ground, stage, prefix) } -> std::same_as<std::vector<double>>;
  /// Of a sort that has some mass.
  {
    target.alternatives(guide, ground, stage, prefix, /*sort=*/number)
    } -> std::same_as<std::vector<Alternative>>;
  /// Makes a prefix longer by an alternative; the extension's weight is 1, or 0 where the
  /// simulation failed. The same each time.
  { target.take(guide, ground, stage, number, longer) } -> std::same_as<Extension>;
};

}  // namespace sleight::sampling
