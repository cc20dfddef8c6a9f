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
// for any number of particles, and so is that of P(satisfied), the integral of p_w over
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
// Memory: as many prefixes as there are particles, and as many again while they are resampled.
// Sources: C. Andrieu, A. Doucet, R. Holenstein, Particle Markov chain Monte Carlo methods (Journal
// of the Royal Statistical Society B 72, 2010); Chopin and Papaspiliopoulos (stages.h), chapter 16.
#pragma once

#include <cstdint>
#include <functional>
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

/// Makes the islands of one chain. REQUIRES: target and guide outlive it.
template <ActsInStages T>
class Islands {
 public:
  using State = typename T::State;
  /// Hears of each simulation.
  using Told = std::function<void(const SimulationReport&)>;

  Islands(
      const T& target, const typename T::Guide& guide, const IslandOptions& options,
      const ChainStreams& streams, Told told = [](const SimulationReport&) {})
      : target_(&target),
        guide_(&guide),
        options_(options),
        streams_(streams),
        told_(std::move(told)) {
    CHECK(target.stages() >= 1 && target.stages() <= k_stages_max);
    CHECK_GE(options.particles, 1U);
  }

  /// Of the decision on an island: no local move's.
  random::Stream acceptance_of(std::uint64_t number) const {
    return stream_of(random::Purpose::particle, number, 1);
  }

  /// The `number`-th island.
  Island<T> free(std::uint64_t number) const { return made(number, nullptr); }
  /// The same given that the state was drawn from it: particle 0 keeps its path. REQUIRES:
  /// p_w p_c^beta > 0 of the state; two particles at least.
  Island<T> given(std::uint64_t number, const State& state) const {
    CHECK_GE(options_.particles, 2U);
    return made(number, &state);
  }

 private:
  /// An island in the making.
  struct Making {
    std::uint64_t number;
    const State* retained;  ///< the state whose path particle 0 keeps; null: none
    typename T::Ground ground;
    std::vector<typename T::Prefix> prefixes;
    std::vector<double> log_potentials;
    IslandWeights weights;
  };

  random::Stream stream_of(random::Purpose purpose, std::uint64_t number, std::uint32_t stage,
                           std::uint32_t particle = 0) const {
    return random::Stream({.seed = streams_.seed,
                           .chain = streams_.chain,
                           .replica = base::ReplicaId{particle},
                           .purpose = purpose},
                          number * k_stages_max + stage);
  }

  Island<T> made(std::uint64_t number, const State* retained) const {
    Making making = begun(number, retained);
    for (std::uint32_t stage = 0; stage < target_->stages(); ++stage) {
      if (stage > 0) resample_unequal(making, stage - 1);
      for (std::uint32_t n = 0; n < options_.particles; ++n)
        if (!making.weights.is_dead(n)) extend(making, stage, n);
      if (retained != nullptr && making.weights.is_dead(0)) return {.is_unreachable = true};
      if (making.weights.all_dead()) return {};
    }
    return finished(making);
  }

  /// Draws the ground, and puts all particles on it.
  Making begun(std::uint64_t number, const State* retained) const {
    random::Stream stream = stream_of(random::Purpose::ground, number, 0);
    Making making{.number = number,
                  .retained = retained,
                  .ground = retained == nullptr ? target_->draw_ground(*guide_, stream)
                                                : target_->ground_given(*guide_, *retained, stream),
                  .prefixes = {},
                  .log_potentials = std::vector<double>(options_.particles, 0),
                  .weights = IslandWeights(options_.particles)};
    for (const SimulationReport& report : target_->simulations_of(making.ground))
      told_(report);
    making.prefixes.assign(options_.particles, target_->no_stages(*guide_, making.ground));
    return making;
  }

  /// Extends a particle, and weighs what came of it: after the last stage by p_c.
  void extend(Making& making, std::uint32_t stage, std::uint32_t n) const {
    typename T::Prefix& prefix = making.prefixes[n];
    random::Stream stream = stream_of(random::Purpose::extension, making.number, stage, n);
    const Extension extension =
        making.retained != nullptr && n == 0
            ? target_->extend_as(*guide_, making.ground, *making.retained, stage, prefix)
            : target_->extend(*guide_, making.ground, stage, prefix, stream);
    told_(extension.simulation);
    if (extension.log_weight == k_log_zero || is_refused<T>(extension.simulation)) {
      making.weights.kill(n);
      return;
    }
    const double log_potential = stage + 1 == target_->stages()
                                     ? log_constraint_of(prefix)
                                     : target_->log_potential(*guide_, making.ground, prefix);
    if (log_potential == k_log_zero) {
      making.weights.kill(n);
      return;
    }
    making.weights.add(n, extension.log_weight + (log_potential - making.log_potentials[n]));
    making.log_potentials[n] = log_potential;
  }

  /// log p_c^beta of a prefix of all stages.
  double log_constraint_of(const typename T::Prefix& prefix) const {
    return tempered_log_density(0, target_->log_constraint(target_->outcome_of(prefix)),
                                options_.inverse_temperature);
  }

  void resample_unequal(Making& making, std::uint32_t stage) const {
    const std::vector<double> shares = making.weights.shares();
    if (effective_size(shares) >= options_.resample_below * options_.particles) return;
    random::Stream stream = stream_of(random::Purpose::resampling, making.number, stage);
    const std::vector<std::uint32_t> ancestors = making.retained == nullptr
                                                     ? resampled(shares, stream)
                                                     : resampled_with_first(shares, stream);
    std::vector<typename T::Prefix> prefixes;
    std::vector<double> log_potentials;
    prefixes.reserve(ancestors.size());
    for (const std::uint32_t ancestor : ancestors) {
      prefixes.push_back(making.prefixes[ancestor]);
      log_potentials.push_back(making.log_potentials[ancestor]);
    }
    making.prefixes = std::move(prefixes);
    making.log_potentials = std::move(log_potentials);
    making.weights.start_again();
  }

  /// Draws one particle by weight, and estimates P(satisfied).
  Island<T> finished(const Making& making) const {
    const std::vector<double> shares = making.weights.shares();
    Island<T> island{.log_z = making.weights.log_z(), .effective_size = effective_size(shares)};
    LogSum satisfied;
    for (std::uint32_t n = 0; n < options_.particles; ++n) {
      const bool is_one =
          !making.weights.is_dead(n) && target_->satisfied(target_->outcome_of(making.prefixes[n]));
      // Without p_c, which is the last potential.
      satisfied.add(is_one ? making.weights.log_weight(n) - making.log_potentials[n] : k_log_zero);
      island.satisfied += is_one ? 1U : 0U;
    }
    island.log_satisfied = making.weights.log_z_before() + satisfied.log_mean();
    random::Stream stream = stream_of(random::Purpose::particle, making.number, 0);
    const typename T::Prefix& drawn = making.prefixes[random::draw_by_share(shares, stream)];
    State state = target_->state_of(making.ground, drawn);
    typename T::Outcome outcome = target_->outcome_of(drawn);
    const double log_prior = target_->log_prior(state);
    const double log_constraint = target_->log_constraint(outcome);
    island.drawn = Sample<T>{std::move(state), std::move(outcome), log_prior, log_constraint};
    return island;
  }

  const T* target_;
  const typename T::Guide* guide_;
  IslandOptions options_;
  ChainStreams streams_;
  Told told_;
};

}  // namespace sleight::sampling
