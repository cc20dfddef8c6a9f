// An effective sample size is the number of independent draws that would estimate as accurately.
//
// Idea. S draws of a stationary chain are worth S / tau independent draws, where tau = 1 + 2 (rho_1
// + rho_2 + ...) sums the autocorrelations. The halves of all chains together yield one estimate of
// each rho_t. The estimate includes the distance between the halves' means. For a reversible chain,
// sums of two neighbouring terms are positive. The total ends where a sum of two terms turns
// negative, and the sums are made non-increasing (Geyer, "Practical Markov chain Monte Carlo",
// Statistical Science 7 (1992) 473-483, section 3.3). S draws of an antithetic chain are worth more
// than S independent draws, but count as at most S log10 S.
// Source: Vehtari et al. 2021 (transforms.h). Results agree with those of the R package posterior
// 1.4.0 to a relative error of 1e-10 (tests/posterior). As in posterior, if half chains have three
// to five draws, the effective sample size is half the number of draws. There are two exceptions.
// If the sum of two terms is exactly 0, as in short series of few values, our total stops there; in
// posterior, rounding decides whether the total stops. If the variance overflows, posterior returns
// half the number of draws, but these functions return NaN.
//
// The result is NaN if a draw is NaN or infinite, if all draws are within 2.2e-16 of each other, if
// a half has fewer than three draws (see split_in_halves for two and three draws), or if the
// variance overflows. If the number of draws is odd, the middle draw counts only where stated. All
// functions REQUIRE that `draws` meets the requirements of Chains. Cost: O(n log n). Thread safety:
// pure functions.
#pragma once

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Returns the effective sample size of the draws' normal scores. The result describes the middle
/// of the distribution. Infinite draws are allowed, because they have ranks.
double ess_bulk(const Chains& draws);

/// Returns the effective sample size in the tails: the smaller of ess_quantile at 0.05 and at 0.95.
/// The result is also NaN if a quantile equals the greatest draw. This is so for most two-valued
/// quantities.
double ess_tail(const Chains& draws);

/// Returns the effective sample size for the mean. The draws must have a finite variance.
double ess_mean(const Chains& draws);

/// Returns the effective sample size of the indicators (draw <= quantile). NaN if all are true.
/// Probability 1 counts as 1 - 0.5 / (number of all draws). REQUIRES: probability in [0, 1].
double ess_quantile(const Chains& draws, double probability);

/// Returns the Monte Carlo standard error of the mean, in the unit of the draws: the standard
/// deviation of all draws, divided by sqrt(ess_mean).
double mcse_mean(const Chains& draws);

}  // namespace sleight::sampling
