// A Monte Carlo standard error is an estimate's error due to the finite number of draws. Errors
// shrink as 1 / sqrt(ESS) and have the unit of the draws.
// Source: Vehtari et al. 2021 (transforms.h). Results agree with those of the R package posterior
// 1.4.0 to a relative error of 1e-10 (tests/posterior).
//
// The error is NaN if a draw is NaN or infinite, if all draws are equal, if halves of chains have
// fewer than three draws (see split_in_halves for two and three draws), or if the effective sample
// size is NaN. Thread safety: pure functions.
#pragma once

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Returns the standard error of the mean: the standard deviation of all draws, divided by
/// sqrt(ess_mean).
double mcse_mean(const Chains& draws);

}  // namespace sleight::sampling
