// A map of throws that bring a die to its goals. The map is learnt from throws of the die without
// other dice.
//
// The result of a throw depends chaotically on its start orientation, but the final place depends
// mostly on the throw's speed and position. This dependence is nearly linear, but noisy. So the map
// treats a throw's random components and its signed misses as jointly normal. Components are
// standard scores. The map draws throws from the density
//
//   q = prior_share p + (1 - prior_share) g,
//
// where p is the prior's density, and g is the scores' density on the condition that all misses are
// 0. The start orientation keeps its prior. A throw drawn from q has the weight v = p / q, which is
// at most 1 / prior_share. So even a bad map gives correct results, and it costs no more than a
// factor of 1 / prior_share.
//
// Thread safety: values and pure functions.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "common/random/stream.h"
#include "worker/worlds/dice/goals.h"
#include "worker/worlds/dice/parameters.h"
#include "worker/worlds/dice/state.h"

namespace sleight::worlds::dice {

/// A throw of one die without the other dice. The die comes to rest.
struct LoneThrow {
  DieThrow thrown;
  std::vector<Miss> misses;  ///< of the same goals for every throw
};

class ThrowMap {
 public:
  static constexpr double k_prior_share = 0.2;

  /// Learns the map of a die with this start. The density q is the prior if no goal has signed
  /// misses, if there are too few throws, or if only the orientation is random.
  ThrowMap(const DieStart& start, std::span<const LoneThrow> throws);

  DieThrow draw(random::Stream& stream) const;
  /// Returns v = p / q. REQUIRES: fixed components have the start's values.
  double prior_over_q(const DieThrow& one) const;
  bool is_prior() const { return is_prior_; }
  /// Returns false if fewer than one in 10,000 prior throws are this far from the start's means.
  /// The squares of n scores add up to at least n + 2 sqrt(n t) + 2 t with probability at most e^-t
  /// (Laurent and Massart, Adaptive estimation of a quadratic functional by model selection, Annals
  /// of Statistics 28, 2000, lemma 1).
  bool is_plausible(const DieThrow& one) const;

 private:
  /// Position, velocity and spin along three axes.
  static constexpr std::size_t k_components_max = 9;
  using Scores = std::array<double, k_components_max>;

  struct Component {
    std::size_t place;  ///< index in (position, velocity, spin)
    double mean;
    double sd;
  };

  Scores scores_of(const DieThrow& one) const;
  void learn(std::span<const LoneThrow> throws);
  double log_g_over_p(const Scores& scores) const;

  DieStart start_;
  std::vector<Component> components_;
  bool is_prior_ = true;
  Scores mean_{};                                ///< mean of g
  std::array<Scores, k_components_max> root_{};  ///< Cholesky root of the covariance
  double log_root_determinant_ = 0;
};

}  // namespace sleight::worlds::dice
