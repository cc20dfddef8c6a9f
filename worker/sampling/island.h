// Islands: sequential Monte Carlo along the animation.
//
// An island's particles are prefixes of one ground. Each stage extends every particle by a choice,
// and multiplies the particle's weight by the choice's importance weight and by the change of
// potential. Unequal weights cause resampling.
//
//   Island on a given ground:
//     Each particle starts as the prefix without stages. Its weight is 1.
//     For each stage:
//       Extend each particle; weight *= p / q * psi after / psi before.
//       Before the next stage, if the effective size is below a share of the particles:
//         Z *= mean weight; resample; set all weights to 1.
//     Z *= mean weight; draw one particle by weight.
//
// After the last stage p_c replaces psi. For any number of particles, the result is an unbiased
// estimate of
//
//   Z = integral of p_w p_c^beta.
//
// The estimate of P(satisfied), the integral of p_w over states that satisfy, is unbiased too.
// Islands share nothing.
//
// A conditional island keeps the path of a given state as particle 0. The other particles have an
// island's distribution, conditioned on this path being the island's draw. Drawing one of the
// island's particles is a Markov chain step that leaves p_w p_c^beta invariant (particle Gibbs).
// The independence sampler over islands (particle_steps.h) uses the conditional island's Z as the
// current state's Z.
//
// If a target can list its choices, an island's particles may choose together (joint). Each new
// particle extends an old particle by an alternative. The pair (old particle, alternative) is drawn
// from all such pairs, with probability proportional to weight times the choice's density q. The
// draws are systematic, over pairs in order of their sort.
//
//     Resample and extend:
//       mass = sum of weight * q over pairs; draw pairs in proportion to weight * q / mass.
//       Z *= mass / particles; weight = p / q * psi after / psi before.
//
// The expected number of draws of each pair is the same as for independent draws, so Z stays
// unbiased. But for each sort, the number of particles differs from its expectation by at most one.
// So rare sorts with large weights make Z vary less.
//
// Invariants
//   1. Random numbers are addressed by (seed, chain, island, stage, particle). An island is a pure
//      function of its streams, its number and, if conditional, the retained state.
//   2. A particle of weight 0 is dead and is not extended. If all particles are dead, Z is 0.
// Memory: one prefix per particle, and two during resampling.
// Sources: Andrieu, Doucet, Holenstein, Particle Markov chain Monte Carlo methods (Journal of the
// Royal Statistical Society B 72, 2010); Chopin and Papaspiliopoulos (stages.h), chapter 16.
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
  /// If the particles' effective size is below this share of their number, they are resampled.
  double resample_below = 0.5;
};

template <ActsInStages T>
struct Island {
  double log_z = k_log_zero;          ///< Log of an unbiased estimate of Z (see above).
  double log_satisfied = k_log_zero;  ///< Log of an unbiased estimate of P(satisfied).
  /// One of the particles, drawn by weight. Empty if Z is 0.
  std::optional<Sample<T>> drawn{};
  double effective_size = 0;    ///< Effective size of the last stage's particles.
  std::uint32_t satisfied = 0;  ///< Number of particles whose final state satisfies.
  /// No island exists, because a prefix of the retained state has psi = 0.
  bool is_unreachable = false;
};

/// Makes the islands of one chain. REQUIRES: target and guide outlive this object.
template <ActsInStages T>
class Islands {
 public:
  using State = typename T::State;
  /// Callback that receives each simulation's report.
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

  /// Stream for accepting or rejecting an island. Local moves use other streams.
  random::Stream acceptance_of(std::uint64_t number) const {
    return stream_of(random::Purpose::particle, number, 1);
  }

  /// Makes the `number`-th island.
  Island<T> free(std::uint64_t number) const { return made(number, nullptr); }
  /// Makes the `number`-th island. If choices can be listed, the island's particles choose
  /// together.
  Island<T> joint(std::uint64_t number) const {
    if constexpr (ListsChoices<T>) {
      Making making = begun(number, nullptr);
      for (std::uint32_t stage = 0; stage < target_->stages(); ++stage) {
        choose_together(making, stage);
        if (making.weights.all_dead()) return {};
      }
      return finished(making);
    } else {
      return free(number);
    }
  }
  /// Makes a conditional island. `state` is particle 0. REQUIRES: at least two particles, and p_w
  /// p_c^beta > 0 at `state`.
  Island<T> given(std::uint64_t number, const State& state) const {
    CHECK_GE(options_.particles, 2U);
    return made(number, &state);
  }

 private:
  struct Making {
    std::uint64_t number;
    const State* retained;  ///< State whose path particle 0 follows; null if free.
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

  /// Draws the ground and starts all particles on it.
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

  struct Choice {
    std::uint32_t particle = 0;
    std::size_t alternative = 0;
    double log_weight = 0;
    bool is_same(const Choice& other) const {
      return particle == other.particle && alternative == other.alternative;
    }
  };

  /// One choice per particle. Choices are drawn systematically, in proportion to weight times mass.
  /// For this draw, masses are ordered by sort, then by particle. `log_mass` is the log of the
  /// mean, over particles, of weight times mass.
  struct Chosen {
    std::vector<Choice> choices;
    double log_mass = k_log_zero;
  };
  Chosen chosen(const Making& making, std::uint32_t stage) const requires ListsChoices<T> {
    // Compute each particle's mass in each sort, multiplied by the particle's share of all weight.
    const std::vector<double> shares = making.weights.shares();
    const std::size_t sorts = target_->sorts();
    const std::size_t particles = options_.particles;
    std::vector<double> masses(sorts * particles, 0);  // By sort, then by particle.
    double sum = 0;
    for (std::uint32_t n = 0; n < particles; ++n) {
      if (making.weights.is_dead(n)) continue;
      const std::vector<double> of_sort =
          target_->masses(*guide_, making.ground, stage, making.prefixes[n]);
      for (std::size_t sort = 0; sort < sorts; ++sort)
        sum += masses[sort * particles + n] = shares[n] * of_sort[sort];
    }
    if (!(sum > 0)) return {};
    Chosen chosen{.choices = {}, .log_mass = making.weights.log_mean() + math::log(sum)};

    random::Stream stream = stream_of(random::Purpose::resampling, making.number, stage);
    const double step = sum / static_cast<double>(particles);
    double next = step * stream.uniform();
    double end = 0;
    for (std::size_t i = 0; i < masses.size(); ++i) {
      const double begin = std::exchange(end, end + masses[i]);
      if (next >= end || chosen.choices.size() == particles) continue;
      // Choose the alternatives that the next systematic steps select.
      const auto n = static_cast<std::uint32_t>(i % particles);
      const std::vector<Alternative> all =
          target_->alternatives(*guide_, making.ground, stage, making.prefixes[n], i / particles);
      CHECK(!all.empty());
      std::size_t at = 0;
      double passed = begin + shares[n] * all[0].mass;
      for (; next < end && chosen.choices.size() < particles; next += step) {
        while (next >= passed && at + 1 < all.size())
          passed += shares[n] * all[++at].mass;
        chosen.choices.push_back({n, all[at].number, math::log(all[at].weight)});
      }
    }
    // Rounding may omit the last choice.
    CHECK(!chosen.choices.empty());
    chosen.choices.resize(particles, chosen.choices.back());
    return chosen;
  }

  /// Resamples and extends in one step.
  void choose_together(Making& making, std::uint32_t stage) const requires ListsChoices<T> {
    const Chosen chosen = this->chosen(making, stage);
    making.weights.start_again(chosen.log_mass);
    std::vector<typename T::Prefix> prefixes;
    std::vector<double> log_potentials;
    prefixes.reserve(options_.particles);
    for (std::uint32_t n = 0; n < options_.particles; ++n) {
      if (chosen.choices.empty()) {
        making.weights.kill(n);
        continue;
      }
      const Choice& choice = chosen.choices[n];
      // If the choice equals the previous particle's choice, copy the previous particle's result.
      if (n > 0 && chosen.choices[n - 1].is_same(choice)) {
        prefixes.push_back(prefixes.back());
        log_potentials.push_back(log_potentials.back());
        making.weights.copy(n - 1, n);
        continue;
      }
      prefixes.push_back(making.prefixes[choice.particle]);
      log_potentials.push_back(making.log_potentials[choice.particle]);
      Extension extension =
          target_->take(*guide_, making.ground, stage, choice.alternative, prefixes.back());
      extension.log_weight += choice.log_weight;
      weigh(making, stage, n, extension, prefixes.back(), log_potentials.back());
    }
    if (prefixes.empty()) return;
    making.prefixes = std::move(prefixes);
    making.log_potentials = std::move(log_potentials);
  }

  void extend(Making& making, std::uint32_t stage, std::uint32_t n) const {
    typename T::Prefix& prefix = making.prefixes[n];
    random::Stream stream = stream_of(random::Purpose::extension, making.number, stage, n);
    const Extension extension =
        making.retained != nullptr && n == 0
            ? target_->extend_as(*guide_, making.ground, *making.retained, stage, prefix)
            : target_->extend(*guide_, making.ground, stage, prefix, stream);
    weigh(making, stage, n, extension, prefix, making.log_potentials[n]);
  }

  /// Updates a particle's weight after its extension. After the last stage, p_c is the potential.
  void weigh(Making& making, std::uint32_t stage, std::uint32_t n, const Extension& extension,
             const typename T::Prefix& prefix, double& log_potential_before) const {
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
    making.weights.add(n, extension.log_weight + (log_potential - log_potential_before));
    log_potential_before = log_potential;
  }

  /// Returns log p_c^beta of a complete prefix.
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
      // Remove p_c, which is the last potential, from the weight.
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
