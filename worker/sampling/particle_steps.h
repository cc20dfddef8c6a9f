// Markov chain steps by islands (island.h), for a world that acts in stages. Both steps leave p_w
// p_c^beta invariant. Potentials and the number of particles only affect mixing.
//
//   Independence step: accepts a free island with probability min(1, Z' / Z). Z' is the free
//     island's estimate. The current state was drawn from an island; Z is that island's estimate.
//     An accepted island's draw is the next state.
//   Conditional step: makes an island with the current state's path. The island's draw is the next
//     state.
//
// If no path of prefixes with positive potentials leads to a state, both steps leave that state
// unchanged and never produce it. Only local moves can reach such a state.
//
// An accepted local move makes the island's Z stale, because this Z belongs to another state. The
// next independence step then draws a conditional island, and uses only its Z. The step must not
// use that island's draw. Staleness depends on the state. If the state chooses the step, the target
// isn't invariant (a test shows this).
// Source: Andrieu, Doucet, Holenstein (island.h), sections 2.4.2 and 2.4.3.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "common/math/elementary.h"
#include "common/random/stream.h"
#include "worker/sampling/island.h"
#include "worker/sampling/island_estimate.h"

namespace sleight::sampling {

/// A chain's current state, and log Z of the island from which the state was drawn. Empty log Z:
/// stale.
template <ActsInStages T>
struct ParticleSample {
  Sample<T> sample;
  std::optional<double> log_z{};
};

template <ActsInStages T>
IslandEstimate estimate_of(const Island<T>& island) {
  return {.log_z = island.log_z,
          .log_satisfied = island.log_satisfied,
          .effective_size = island.effective_size};
}

/// Returns the conditional island's estimate. The draw is the next state. REQUIRES: the same as
/// Islands::given; a chain uses each number once.
template <ActsInStages T>
IslandEstimate conditional_step(const Islands<T>& islands, std::uint64_t number,
                                ParticleSample<T>& current) {
  Island<T> island = islands.given(number, current.sample.state);
  if (island.is_unreachable) return {};
  CHECK(island.drawn.has_value());
  IslandEstimate estimate = estimate_of(island);
  estimate.accepted = true;
  current = {.sample = std::move(*island.drawn), .log_z = island.log_z};
  return estimate;
}

/// Returns the free island's estimate. Uses island numbers `number` and number + 1. REQUIRES: as
/// conditional_step.
template <ActsInStages T>
IslandEstimate independence_step(const Islands<T>& islands, std::uint64_t number,
                                 ParticleSample<T>& current) {
  // If Z is stale, estimate it from an island that is conditioned on the current state.
  bool stays = false;
  if (!current.log_z) {
    const Island<T> given = islands.given(number, current.sample.state);
    stays = given.is_unreachable;
    if (!stays) current.log_z = given.log_z;
  }

  // Propose a free island.
  Island<T> island = islands.free(number + 1);
  IslandEstimate estimate = estimate_of(island);
  if (stays || !island.drawn) return estimate;
  random::Stream acceptance = islands.acceptance_of(number + 1);
  const double log_u = math::log(acceptance.uniform());
  estimate.accepted = log_u < island.log_z - *current.log_z;
  if (estimate.accepted) current = {.sample = std::move(*island.drawn), .log_z = island.log_z};
  return estimate;
}

}  // namespace sleight::sampling
