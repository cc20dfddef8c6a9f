// Islands: sequential Monte Carlo along the animation.
//
// An island's particles are prefixes of one ground. Stage by stage each is extended by a choice of
// its own and weighed by the choice's importance weight and by how its potential changed; when
// weights have become unequal, particles are resampled.
//
//   island(ground):
//     each particle: the prefix without stages, weight 1
//     for each stage:
//       each particle: extend; weight *= p / q * psi after / psi before
//       before the next stage, if the effective size is below a share of the particles:
//         Z *= mean weight; resample; weights 1
//     Z *= mean weight; draw one particle by weight
//
// After the last stage p_c stands in the place of psi, so Z is an unbiased estimate of
//
//   Z = integral of p_w p_c^beta,
//
// for any number of particles, and so is `satisfied_z` of P(satisfied), the integral of p_w over
// states that satisfy. Islands share nothing.
//
// A conditional island holds one path fixed, that of a given state, as particle 0. It is drawn from
// the distribution of an island given that this path was drawn from it: a draw of its particles is
// a step that keeps p_w p_c^beta (particle Gibbs), and its Z is what the independence sampler over
// islands needs of the present state (particle_steps.h).
//
// Invariants
//   1. Random numbers are addressed by (seed, chain, island, stage, particle): an island is a pure
//      function of its streams, its number and, if conditional, the state.
//   2. A particle whose weight is 0 is dead: it is not extended. When all are, Z is 0.
// Memory: as many prefixes and samples as there are particles.
// Sources: C. Andrieu, A. Doucet, R. Holenstein, Particle Markov chain Monte Carlo methods (Journal
// of the Royal Statistical Society B 72, 2010); Chopin and Papaspiliopoulos (stages.h), chapter 16.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "common/random/discrete_distributions.h"
#include "worker/sampling/island_weights.h"
#include "worker/sampling/log_sum.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/resampling.h"
#include "worker/sampling/stages.h"

namespace sleight::sampling {

struct IslandOptions {
  std::uint32_t particles = 64;
  double inverse_temperature = 1;
  /// Particles are resampled when their effective size is below this share of their number.
  double resample_below = 0.5;
};

template <ActsInStages T>
struct Island {
  double log_z = k_log_zero;          ///< of an unbiased estimate of the integral of p_w p_c^beta
  double log_satisfied = k_log_zero;  ///< of an unbiased estimate of P(satisfied)
  /// Drawn by weight among the particles; none if Z is 0.
  std::optional<Sample<T>> drawn{};
  double effective_size = 0;    ///< of the last stage's particles, by weight
  std::uint32_t satisfied = 0;  ///< particles that satisfy at last
  /// A retained state that no path of prefixes reaches: one of them has psi = 0. Then the island is
  /// none.
  bool is_unreachable = false;
};

namespace detail {

/// The ground and the particles of an island in the making.
template <ActsInStages T>
struct Particles {
  typename T::Ground ground;
  std::vector<typename T::Prefix> prefixes;
  IslandWeights weights;

  /// The n-th particle as a sample. REQUIRES: it has all stages.
  Sample<T> sample(const T& target, std::size_t n) const {
    typename T::State state = target.state_of(ground, prefixes[n]);
    typename T::Outcome outcome = target.outcome_of(prefixes[n]);
    const double log_prior = target.log_prior(state);
    const double log_constraint = target.log_constraint(outcome);
    return {std::move(state), std::move(outcome), log_prior, log_constraint};
  }
  /// Each descends from one of the present ones.
  void descend_from(const std::vector<std::uint32_t>& ancestors) {
    std::vector<typename T::Prefix> next;
    next.reserve(prefixes.size());
    for (const std::uint32_t ancestor : ancestors)
      next.push_back(prefixes[ancestor]);
    prefixes = std::move(next);
    weights.start_again();
  }
};

}  // namespace detail

/// The `number`-th island of a chain. `retained`: the state whose path particle 0 keeps; null for a
/// free island. `told` hears of each simulation. REQUIRES: a retained state has p_w p_c^beta > 0;
/// one particle at least, two if one is retained.
template <ActsInStages T, class Told>
Island<T> make_island(const T& target, const typename T::Guide& guide, const IslandOptions& options,
                      const ChainStreams& streams, std::uint64_t number,
                      const typename T::State* retained, const Told& told) {
  const std::uint32_t stages = target.stages();
  CHECK(stages >= 1 && stages <= k_stages_max);
  CHECK_GE(options.particles, retained == nullptr ? 1U : 2U);
  const auto stream_of = [&](random::Purpose purpose, std::uint32_t stage, std::uint32_t particle) {
    return random::Stream({.seed = streams.seed,
                           .chain = streams.chain,
                           .replica = base::ReplicaId{particle},
                           .purpose = purpose},
                          number * k_stages_max + stage);
  };

  // Draw the ground, and put all particles on it.
  random::Stream ground_stream = stream_of(random::Purpose::ground, 0, 0);
  detail::Particles<T> all{.ground = retained == nullptr
                                         ? target.draw_ground(guide, ground_stream)
                                         : target.ground_given(guide, *retained, ground_stream),
                           .prefixes = {},
                           .weights = IslandWeights(options.particles)};
  all.prefixes.assign(options.particles, target.no_stages(guide, all.ground));
  std::vector<double> log_potentials(options.particles, 0);
  std::vector<std::optional<Sample<T>>> samples(options.particles);

  for (std::uint32_t stage = 0; stage < stages; ++stage) {
    // Extend each particle, and weigh what came of it.
    for (std::uint32_t n = 0; n < options.particles; ++n) {
      if (all.weights.is_dead(n)) continue;
      random::Stream own = stream_of(random::Purpose::extension, stage, n);
      const Extension extension =
          retained != nullptr && n == 0
              ? target.extend_as(guide, all.ground, *retained, stage, all.prefixes[n])
              : target.extend(guide, all.ground, stage, all.prefixes[n], own);
      told(extension.simulation);
      if (extension.log_weight == k_log_zero || is_refused<T>(extension.simulation)) {
        all.weights.kill(n);
        continue;
      }
      double log_potential = 0;
      if (stage + 1 < stages) {
        log_potential = target.log_potential(guide, all.ground, all.prefixes[n]);
      } else {
        samples[n] = all.sample(target, n);
        log_potential =
            tempered_log_density(0, samples[n]->log_constraint, options.inverse_temperature);
      }
      if (log_potential == k_log_zero) {
        all.weights.kill(n);
        continue;
      }
      all.weights.add(n, extension.log_weight + (log_potential - log_potentials[n]));
      log_potentials[n] = log_potential;
    }
    if (retained != nullptr && all.weights.is_dead(0)) return {.is_unreachable = true};
    if (all.weights.all_dead()) return {};

    // Resample where weights have become unequal.
    if (stage + 1 == stages) break;
    const std::vector<double> shares = all.weights.shares();
    if (effective_size(shares) >= options.resample_below * options.particles) continue;
    random::Stream own = stream_of(random::Purpose::resampling, stage, 0);
    const std::vector<std::uint32_t> ancestors =
        retained == nullptr ? resampled(shares, own) : resampled_with_first(shares, own);
    std::vector<double> inherited;
    for (const std::uint32_t ancestor : ancestors)
      inherited.push_back(log_potentials[ancestor]);
    log_potentials = std::move(inherited);
    all.descend_from(ancestors);
  }

  // Draw one particle by weight.
  const std::vector<double> shares = all.weights.shares();
  random::Stream own = stream_of(random::Purpose::particle, 0, 0);
  Island<T> island{.log_z = all.weights.log_z(), .effective_size = effective_size(shares)};
  const std::size_t drawn = random::draw_by_share(shares, own);
  LogSum satisfied;
  for (std::uint32_t n = 0; n < options.particles; ++n) {
    const bool is_one =
        samples[n] && !all.weights.is_dead(n) && target.satisfied(samples[n]->outcome);
    satisfied.add(is_one ? all.weights.log_weight(n) -
                               tempered_log_density(0, samples[n]->log_constraint,
                                                    options.inverse_temperature)
                         : k_log_zero);
    island.satisfied += is_one ? 1U : 0U;
  }
  island.log_satisfied = all.weights.log_z_before() + satisfied.log_mean();
  island.drawn = std::move(samples[drawn]);
  return island;
}

/// A free island.
template <ActsInStages T>
Island<T> make_island(const T& target, const typename T::Guide& guide, const IslandOptions& options,
                      const ChainStreams& streams, std::uint64_t number) {
  return make_island(target, guide, options, streams, number, nullptr,
                     [](const SimulationReport&) {});
}

}  // namespace sleight::sampling
