// Monte Carlo standard errors: the error of an estimate that is due to the finite number of draws.
// Errors shrink as 1 / sqrt(ESS) and have the unit of the draws.
// Source: Vehtari et al. (2021), see transforms.h, for quantiles; the delta method for the standard
// deviation. Results equal those of R's posterior 1.4.0 within 1e-10 relative (tests/posterior).
// The error of the standard deviation is a difference of fourth powers; for draws that take two
// values almost equally often, both programs return rounding errors.
//
// NaN means one of: a draw is NaN or infinite; all draws are equal; the halves of chains have fewer
// than three draws (see split_in_halves for two and three); the effective sample size is NaN.
// Thread safety: pure functions.
#pragma once

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Returns the standard error of the mean: the standard deviation of all draws over sqrt(ess_mean).
double mcse_mean(const Chains& draws);

}  // namespace sleight::sampling
