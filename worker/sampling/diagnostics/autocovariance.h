// Autocovariances at all lags by the fast Fourier transform, in O(n log n).
//
// Idea. By the Wiener-Khinchin theorem, the autocovariances of a series are the inverse transform
// of its transform's squared moduli. Appending as many zeros as there are values prevents
// wrap-around. Only the sum over chains is needed, so the squared moduli are added before one
// inverse transform. Two real chains share one transform as the real and imaginary part of z,
// because the real part of the autocovariance of z is the sum of both chains' autocovariances.
//
// The transform is the standard one for powers of two (Cooley and Tukey 1965). The transform's
// angles come from common/math, so results have the same bits on every machine.
// Thread safety: pure functions.
#pragma once

#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// Returns the mean over chains of (1/draws) sum of (x[i] - m)(x[i + t] - m) over i, where m is the
/// chain's own mean, at lags t = 0 .. draws - 1. The error at every lag is some 1e-16 of the value
/// at lag 0. A chain whose draws are all equal contributes exactly 0. REQUIRES: values finite.
std::vector<double> mean_autocovariances(const Chains& draws);

}  // namespace sleight::sampling
