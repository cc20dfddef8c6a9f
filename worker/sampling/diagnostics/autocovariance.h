// Computes autocovariances at all lags by the fast Fourier transform, in O(n log n).
//
// Idea. By the Wiener-Khinchin theorem, the inverse transform of |transform of a series|^2 is the
// autocovariances of the series. To prevent wrap-around, a zero is appended for each value. Only
// the sum over chains is needed, so the squared moduli are added before one inverse transform. One
// transform handles two real chains, which are the real and the imaginary part of z. The real part
// of z's autocovariance is the sum of both chains' autocovariances.
//
// The transform is the standard transform for powers of two (Cooley and Tukey 1965). The
// transform's angles come from common/math, so results have the same bits on every machine.
// Thread safety: pure functions.
#pragma once

#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// For each lag t = 0 .. draws - 1, returns the mean over chains of (1/draws) sum over i of (x[i] -
/// m)(x[i + t] - m). Here m is the chain's own mean. The error at every lag is some 1e-16 of the
/// value at lag 0. A chain whose draws are all equal contributes exactly 0. REQUIRES: values
/// finite.
std::vector<double> mean_autocovariances(const Chains& draws);

}  // namespace sleight::sampling
