// Monte Carlo standard errors: how far an estimate from the chains may be off for having finitely
// many draws. The estimated error shrinks as 1 / sqrt(ESS) and has the unit of the draws.
//
// Source: Vehtari et al. (2021), see transforms.h, for quantiles; the delta method for
// the standard deviation. Equal to R's posterior 1.4.0 within 1e-10 relative (tests/posterior); the
// one of the standard deviation is a difference of fourth powers, and of draws that take two values
// almost equally often both programs give its rounding errors.
//
// The meaning of NaN: a draw is NaN or infinite, all are equal, or the halves of chains have fewer
// than three draws (see split_in_halves for two and three); what the effective sample size says.
// Thread safety: pure functions.
#pragma once

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Of the mean: the standard deviation of all draws over sqrt(ess_mean).
double mcse_mean(const Chains& draws);

}  // namespace sleight::sampling
