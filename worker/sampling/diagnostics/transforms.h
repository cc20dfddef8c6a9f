// Building blocks of the diagnostics: moments, quantiles, halves of chains, ranks.
//
// Source of all: Vehtari, Gelman, Simpson, Carpenter, Buerkner, "Rank-normalization, folding, and
// localization: an improved R-hat for assessing convergence of MCMC", Bayesian Analysis 16 (2021)
// 667-718, and the behaviour of the R package posterior 1.4.0.
//
// Sums run in index order, so results depend only on the values and their order.
// Thread safety: pure functions.
#pragma once

#include <span>
#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Returns the mean. If all values are equal, it is exact. REQUIRES: values not empty.
double mean_of(std::span<const double> values);

/// Returns each chain's mean: the sum in index order, divided by the length. The mean is rounded as
/// in posterior. The rounding matters if means are large compared with the variance between them.
std::vector<double> chain_means(const Chains& draws);

/// Returns the sum of squared distances from the mean, divided by n - 1. The result is NaN for a
/// single value. The result is 0 only if all values are equal, or if the squares underflow.
/// REQUIRES: values not empty.
double variance_of(std::span<const double> values);

/// Returns whether a value is NaN or infinite, or all values are within 2.2e-16 of each other. This
/// absolute tolerance is posterior's.
bool is_degenerate(std::span<const double> values);

/// Returns NaN if a value is NaN. REQUIRES: values not empty.
double median_of(std::span<const double> values);

/// Returns the quantile by linear interpolation between order statistics (definition 7 of Hyndman
/// and Fan, "Sample quantiles in statistical packages", American Statistician 50 (1996) 361-365).
/// REQUIRES: values are not empty and have no NaN; probability is in [0, 1].
double quantile_of(std::span<const double> values, double probability);

/// Cuts each chain into two halves of draws/2. If `draws` is odd, omits the middle draw. A single
/// draw stays unchanged. If chains have two or three draws, the result has one chain of all first
/// draws and one chain of all last draws, as in the R package posterior.
OwnedChains split_in_halves(const Chains& draws);

/// Returns the normal score of each value's rank among all chains: the normal quantile of (rank -
/// 3/8)/(count + 1/4) (Blom 1958). Ties get the mean of their ranks. NaN stays NaN, and the other
/// scores are then meaningless.
OwnedChains normal_scores(const Chains& draws);

/// Returns distances from the median of all draws. If one draw is NaN, all distances are NaN.
OwnedChains folded(const Chains& draws);

}  // namespace sleight::sampling
