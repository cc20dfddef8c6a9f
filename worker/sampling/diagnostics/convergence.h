// Whether the chains have mixed, as one scalar that they sample shows it, and in words for people.
//
//   const Convergence height = convergence_of({.values = draws, .chains = 4, .draws = 1000});
//   for (const std::string& line : complaints("height", height)) print(line);
//
// No complaint is no proof: chains that all miss the same mode agree.
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Above this, chains are not taken for mixed: Vehtari et al. (2021), who show that the older
/// 1.1 passes chains that are far from it.
constexpr double k_r_hat_max = 1.01;

/// Bulk and tail effective sample sizes below this are too small: Vehtari et al. (2021). At
/// the limit, the standard error of a mean is 1/20 of the standard deviation.
constexpr double k_ess_min = 400;

/// With more than four chains, this many of each: the paper's 400 is 50 for each half of four
/// chains, below which neither R-hat nor the sample sizes themselves can be relied on.
constexpr double k_ess_per_chain_min = 100;

/// Fewer draws of each chain have no effective sample size: halves need three.
constexpr std::size_t k_draws_per_chain_min = 6;

/// Numbers that can't be given are NaN; each function's header says when.
struct Convergence {
  std::size_t chains = 0;
  std::size_t draws = 0;       ///< of each chain
  std::size_t not_finite = 0;  ///< draws that are NaN or infinite
  std::size_t unmoved = 0;     ///< chains all draws of which are equal
  bool constant = false;       ///< all draws of all chains are equal, and finite
  double mean = 0;             ///< NaN where a draw is not finite
  double sd = 0;               ///< with n - 1; NaN where a draw is not finite, or there is just one
  double mcse_mean = 0;
  double r_hat_bulk = 0;
  double r_hat = 0;
  double ess_bulk = 0;
  double ess_tail = 0;
};

/// REQUIRES: the shape is that of Chains.
Convergence convergence_of(const Chains& draws);

/// The effective sample size that bulk and tail should have: the greater of k_ess_min and
/// k_ess_per_chain_min for each chain.
double ess_wanted(std::size_t chains);

/// Why the chains have not mixed: one sentence for each reason, which opens with the quantity's
/// name and ends without a line break; empty where nothing speaks against it.
///
/// A quantity that is the same everywhere gives no reason. Where r_hat is NaN because the distances
/// from the median are all equal, r_hat_bulk decides; an ess_tail of NaN, whose quantile is the
/// greatest draw, is passed over: such a quantity has two or few values and no tail.
std::vector<std::string> complaints(std::string_view name, const Convergence& convergence);

}  // namespace sleight::sampling
