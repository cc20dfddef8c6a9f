// Markov chain steps by islands (island.h), for a world that acts in stages. Both keep
// p_w p_c^beta, whatever the potentials are and however few particles there are; only how fast they
// move hangs on these.
//
//   independence step  a free island is accepted with probability min(1, Z' / Z), Z that of the
//                      island which the present state was drawn from; then its draw is the state
//   conditional step   an island that keeps the present state's path; its draw is the state, always
//
// Both leave states alone that no path of prefixes with potentials above 0 reaches, and lead to
// none: local moves have to.
//
// After a local move that was accepted the island's Z is that of another state: it is stale. The
// next independence step then draws a new island given the state, of which it takes Z alone. It
// must not take the island's draw too: whether a chain is stale depends on its state, as accepted
// moves do, and steps that are chosen by the state don't keep the target (a test shows it).
//
// Source: Andrieu, Doucet, Holenstein (island.h), sections 2.4.2 and 2.4.3.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "common/math/elementary.h"
#include "common/random/stream.h"
#include "worker/sampling/island.h"

namespace sleight::sampling {

/// A chain's present state, and log Z of the island that it was drawn from; none: stale.
template <ActsInStages T>
struct ParticleSample {
  Sample<T> sample;
  std::optional<double> log_z{};
};

struct ParticleStepReport {
  bool accepted = false;  ///< a conditional step always is, where its state can be reached
  /// Of the step's free island, or of the conditional one.
  double log_z = k_log_zero;
  double log_satisfied = k_log_zero;
  double effective_size = 0;
};

template <ActsInStages T>
ParticleStepReport report_of(const Island<T>& island) {
  return {.log_z = island.log_z,
          .log_satisfied = island.log_satisfied,
          .effective_size = island.effective_size};
}

/// An island given the present state; its draw is the next state. REQUIRES: as Islands::given;
/// islands of a chain have different numbers.
template <ActsInStages T>
ParticleStepReport conditional_step(const Islands<T>& islands, std::uint64_t number,
                                    ParticleSample<T>& current) {
  Island<T> island = islands.given(number, current.sample.state);
  if (island.is_unreachable) return {};
  CHECK(island.drawn.has_value());
  ParticleStepReport report = report_of(island);
  report.accepted = true;
  current = {.sample = std::move(*island.drawn), .log_z = island.log_z};
  return report;
}

/// Uses two numbers of islands, `number` and the next one. A state that no path reaches stays.
/// REQUIRES: as conditional_step.
template <ActsInStages T>
ParticleStepReport independence_step(const Islands<T>& islands, std::uint64_t number,
                                     ParticleSample<T>& current) {
  // Know Z of an island that the present state was drawn from.
  bool stays = false;
  if (!current.log_z) {
    const Island<T> given = islands.given(number, current.sample.state);
    stays = given.is_unreachable;
    if (!stays) current.log_z = given.log_z;
  }

  // Propose a free island.
  Island<T> island = islands.free(number + 1);
  ParticleStepReport report = report_of(island);
  if (stays || !island.drawn) return report;
  random::Stream acceptance = islands.acceptance_of(number + 1);
  const double log_u = math::log(acceptance.uniform());
  report.accepted = log_u < island.log_z - *current.log_z;
  if (report.accepted) current = {.sample = std::move(*island.drawn), .log_z = island.log_z};
  return report;
}

}  // namespace sleight::sampling
