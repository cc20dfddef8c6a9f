// Parts that the diagnostics are put together from: moments, quantiles, halves of chains, ranks.
//
// Source of all: A. Vehtari, A. Gelman, D. Simpson, B. Carpenter, P. Buerkner, "Rank-normalization,
// folding, and localization: an improved R-hat for assessing convergence of MCMC", Bayesian
// Analysis 16 (2021) 667-718, and the behaviour of the R package posterior 1.4.0.
//
// Sums run in index order, so results depend on the values and their order alone.
// Thread safety: pure functions.
#pragma once

#include <span>
#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// The mean, all but correctly rounded, so exact where all values are equal. REQUIRES: values not
/// empty.
double mean_of(std::span<const double> values);

/// The mean of each chain: its sum in index order over its length, no more. The variance between
/// chains is taken from means rounded so in posterior too, which shows where they are large against
/// it: more exact ones would agree to fewer digits.
std::vector<double> chain_means(const Chains& draws);

/// Sum of squared distances from the mean over n - 1; NaN for a single value, 0 only where all are
/// equal (or their squared distances underflow). REQUIRES: values not empty.
double variance_of(std::span<const double> values);

/// Whether a value is NaN or infinite, or all lie within 2.2e-16 of each other, the absolute
/// tolerance of posterior: measures of such values are NaN.
bool is_degenerate(std::span<const double> values);

/// NaN where a value is. REQUIRES: values not empty.
double median_of(std::span<const double> values);

/// The quantile by linear interpolation between order statistics (definition 7 of R. Hyndman and
/// Y. Fan, "Sample quantiles in statistical packages", American Statistician 50 (1996) 361-365).
/// REQUIRES: values not empty and without NaN, probability in [0, 1].
double quantile_of(std::span<const double> values, double probability);

/// Each chain cut into two halves, the middle draw of an odd number left out: 2 chains of draws/2.
/// A single draw stays as it is. Two or three draws, whose halves are single, give posterior's
/// matrix: 2 chains, of all first and all last draws, each as long as there were chains.
OwnedChains split_in_halves(const Chains& draws);

/// Each value's rank among all chains (ties: the mean of their ranks) turned to a normal score, the
/// normal quantile of (rank - 3/8)/(count + 1/4) (G. Blom, 1958). NaN stays NaN, and the other
/// scores then mean nothing.
OwnedChains normal_scores(const Chains& draws);

/// Distances from the median of all draws: what shows differences of scale. All NaN if one is.
OwnedChains folded(const Chains& draws);

}  // namespace sleight::sampling
