// Judges from one scalar whether chains have mixed, and tells people the reasons. Example:
//
//   const Convergence height = convergence_of({.values = draws, .chains = 4, .draws = 1000});
//   for (const std::string& line : complaints("height", height)) print(line);
//
// The absence of complaints is no proof: chains that all miss the same mode agree.
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// If R-hat is above this limit, chains have not mixed (Vehtari et al. 2021, see transforms.h). The
/// paper shows that the older limit of 1.1 accepts chains that are far from mixed.
constexpr double k_r_hat_max = 1.01;

/// Minimum of the effective sample size, both bulk and tail (Vehtari et al. 2021). At this minimum,
/// the standard error of a mean is 1/20 of the standard deviation.
constexpr double k_ess_min = 400;

/// Minimum effective sample size per chain, if there are more than four chains. The paper requires
/// 400 for four chains, so 50 for each half of a chain. Below 50, R-hat and sample sizes are
/// unreliable.
constexpr double k_ess_per_chain_min = 100;

/// Minimum draws per chain for an effective sample size: each half needs three draws.
constexpr std::size_t k_draws_per_chain_min = 6;

/// Undefined numbers are NaN, as each function's header describes.
struct Convergence {
  std::size_t chains = 0;
  std::size_t draws = 0;       ///< Draws of each chain.
  std::size_t not_finite = 0;  ///< Draws that are NaN or infinite.
  std::size_t unmoved = 0;     ///< Chains whose draws are all equal.
  bool constant = false;       ///< All draws of all chains are equal and finite.
  double mean = 0;             ///< NaN if a draw is not finite.
  double sd = 0;               ///< With n - 1. NaN if a draw is not finite, or for a single draw.
  double mcse_mean = 0;
  double r_hat_bulk = 0;
  double r_hat = 0;
  double ess_bulk = 0;
  double ess_tail = 0;
};

/// REQUIRES: `draws` meets the requirements of Chains.
Convergence convergence_of(const Chains& draws);

/// Returns max(k_ess_min, chains * k_ess_per_chain_min).
double ess_wanted(std::size_t chains);

/// Returns the reasons to believe that chains have not mixed. Each sentence opens with the
/// quantity's name and has no line break. The result is empty if there is no reason, or if the
/// quantity is constant. If r_hat is NaN because all distances from the median are equal,
/// r_hat_bulk decides. If ess_tail is NaN, it is ignored, because the quantity then has few values
/// and no tail.
std::vector<std::string> complaints(std::string_view name, const Convergence& convergence);

}  // namespace sleight::sampling
