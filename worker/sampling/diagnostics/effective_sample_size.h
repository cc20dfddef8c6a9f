// Effective sample sizes: how many independent draws would estimate as well as these.
//
// Idea. The variance of an average over a stationary chain is that of one draw, times tau, over the
// number of draws, where tau = 1 + 2 (rho_1 + rho_2 + ...) sums the autocorrelations; so S draws
// are worth S / tau. All chains, cut into halves, give one estimate of each rho_t, which also takes
// in how far their means lie apart. The sum ends where the sum of two neighbouring terms, which is
// positive for a reversible chain, turns negative, and these sums are made to fall (C. Geyer,
// "Practical Markov chain Monte Carlo", Statistical Science 7 (1992) 473-483, section 3.3). At
// most S log10 S is given to antithetic chains, whose draws are worth more than independent ones.
//
// Source: Vehtari et al. (2021), see transforms.h, on effective sample sizes of split chains, of
// ranks and of quantiles. Equal to R's posterior 1.4.0 within 1e-10 relative (tests/posterior),
// peculiarities included: chains whose halves have three to five draws are worth half their number,
// whatever the draws. Two exceptions: where the sum of two terms is 0 in exact arithmetic, which
// happens to short series of few values, rounding decides in posterior whether the sum goes on,
// here it ends; and where the variance overflows, posterior gives half the number of draws, we NaN.
//
// The meaning of NaN: a draw is NaN or infinite (the middle one of an odd number counts only where
// said); all draws lie within 2.2e-16 of each other; a half has fewer than three draws (see
// split_in_halves for two and three draws); or the variance overflows.
// REQUIRES, of all: the shape is that of Chains. Cost: O(n log n). Thread safety: pure functions.
#pragma once

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Of the draws' normal scores: how well the middle of the distribution is known. Infinite draws
/// are welcome here: they have ranks.
double ess_bulk(const Chains& draws);

/// The least of those for the quantiles at 0.05 and 0.95: how well the tails are known. NaN also
/// where a quantile is the greatest draw, as those of a quantity with two values mostly are.
double ess_tail(const Chains& draws);

/// For the mean of the draws as they are, which must have a finite variance.
double ess_mean(const Chains& draws);

/// For the quantile at a probability: of the indicators that a draw is at most the quantile of all
/// draws, which are NaN where all are true. At probability 1, the quantile half a draw below.
/// REQUIRES: probability in [0, 1].
double ess_quantile(const Chains& draws, double probability);

}  // namespace sleight::sampling
