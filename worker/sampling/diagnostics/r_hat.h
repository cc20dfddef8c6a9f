// Split R-hat tests whether chains agree with each other, and whether each chain agrees with itself
// over time.
//
// Idea. Cut every chain into halves. R-hat is sqrt(A / W), where A is the estimated variance of all
// draws together, and W is the variance within a half. R-hat is near 1 for mixed chains, and larger
// if the halves' means differ. Because of rank normalisation, R-hat is valid even if draws have no
// finite moments. Folding about the median turns differences of scale into differences of mean.
// Source: Vehtari et al. 2021 (transforms.h). Results agree with those of the R package posterior
// 1.4.0 to a relative error of 1e-10 (tests/posterior).
//
// R-hat is NaN if a draw in the halves is NaN, if all draws are equal, or if each chain has one
// draw. Infinite draws are allowed if the median is finite. If each half is constant but halves
// differ, R-hat is infinite, or about 1e15 because of rounding. Thread safety: pure functions.
#pragma once

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Returns R-hat of the draws' ranks. This R-hat is sensitive to differences of location.
double r_hat_bulk(const Chains& draws);

/// Returns r_hat_bulk of the draws' distances from the median. This R-hat is sensitive to
/// differences of scale. The result is NaN if all distances are equal, for example if draws have
/// two equally frequent values.
double r_hat_tail(const Chains& draws);

/// Returns the greater of r_hat_bulk and r_hat_tail, or NaN if either is NaN. The R package
/// posterior calls this rhat.
double r_hat(const Chains& draws);

}  // namespace sleight::sampling
