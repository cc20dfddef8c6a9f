// Throws that bring a die to where its goals want it, learnt from throws of that die alone.
//
// How a throw ends is chaotic in its orientation, but where to, is mostly a matter of how fast and
// from where the die was thrown: nearly linear, with noise. So the random components of a throw, as
// standard scores, and by how much it missed its goals are taken for jointly normal, and the throws
// that miss by 0 are the conditional distribution: the density
//
//   q = prior_share p + (1 - prior_share) g,
//
// p the prior's density, g that of these scores (the orientation stays the prior's). Whoever draws
// from q weighs a throw by v = p / q, which is at most 1 / prior_share: the map may be wrong, and
// costs no more than that.
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

/// A throw of a die alone that came to rest, and by how much it missed.
struct LoneThrow {
  DieThrow thrown;
  std::vector<Miss> misses;  ///< of the same goals for every throw
};

class ThrowMap {
 public:
  static constexpr double k_prior_share = 0.2;

  /// Of a die that starts so. Without goals that say where to, with too few throws, or where
  /// nothing is random but the orientation, q is the prior.
  ThrowMap(const DieStart& start, std::span<const LoneThrow> throws);

  DieThrow draw(random::Stream& stream) const;
  /// v = p / q. REQUIRES: the components that are fixed are as the start has them.
  double prior_over_q(const DieThrow& one) const;
  bool is_prior() const { return is_prior_; }
  /// Not so if fewer than one in 10,000 throws of the prior are as far from the start's means: the
  /// squares of n scores add up to n + 2 sqrt(n t) + 2 t with probability e^-t at most (B. Laurent,
  /// P. Massart, Adaptive estimation of a quadratic functional by model selection, Annals of
  /// Statistics 28, 2000, lemma 1).
  bool is_plausible(const DieThrow& one) const;

 private:
  /// Position, velocity and spin along three axes.
  static constexpr std::size_t k_components_max = 9;
  using Scores = std::array<double, k_components_max>;

  /// One random component of the throw.
  struct Component {
    std::size_t place;  ///< of position, velocity and spin, in this order
    double mean;
    double sd;
  };

  Scores scores_of(const DieThrow& one) const;
  void learn(std::span<const LoneThrow> throws);
  double log_g_over_p(const Scores& scores) const;

  DieStart start_;
  std::vector<Component> components_;
  bool is_prior_ = true;
  Scores mean_{};                                ///< of g
  std::array<Scores, k_components_max> root_{};  ///< of g's covariance: lower triangle
  double log_root_determinant_ = 0;
};

}  // namespace sleight::worlds::dice
