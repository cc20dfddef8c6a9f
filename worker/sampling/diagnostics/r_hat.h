// Split R-hat: whether chains agree with each other, and each with itself over time.
//
// Idea. Cut every chain into halves. If all halves sample one distribution, the variance of all
// draws together is that within a half; R-hat is the square root of the ratio of an estimate of the
// former to the latter: near 1 when mixed, larger when the halves' means differ. Rank normalisation
// makes it work without finite moments; folding about the median makes differences of scale
// differences of mean.
//
// Source: Vehtari et al. (2021), see transforms.h, on split, rank-normalised and folded R-hat.
// Equal to R's posterior 1.4.0 within 1e-10 relative (tests/posterior).
//
// The meaning of NaN: a draw (of those that the halves hold) is NaN; all draws are equal; or there
// is one draw per chain. Infinite draws have ranks and are welcome as long as the median is finite.
// Where no half moves but they differ, it is infinite, or some 1e15 since the means are rounded:
// how posterior rounds them is kept. Thread safety: pure functions.
#pragma once

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Of the ranks of the draws: sensitive to differences of location.
double r_hat_bulk(const Chains& draws);

/// Of the ranks of the distances from the median: sensitive to differences of scale. NaN also where
/// all distances are equal, as those of a quantity with two equally frequent values are.
double r_hat_tail(const Chains& draws);

/// The greater of the two, NaN if either is: what posterior calls rhat.
double r_hat(const Chains& draws);

}  // namespace sleight::sampling
