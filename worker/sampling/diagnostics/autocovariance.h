// Autocovariances at all lags at once, by the fast Fourier transform: O(n log n).
//
// Idea. By the Wiener-Khinchin theorem, the autocovariances of a series are the inverse transform
// of the squared moduli of its transform; with as many zeros appended as there are values, none
// wrap around. The sum over chains is wanted alone, so the squared moduli are added up and one
// inverse transform is made; and two real chains go through one transform as the real and imaginary
// part of z, since the real part of the autocovariance of z is the sum of the two.
//
// The transform is the textbook one for powers of two (J. Cooley and J. Tukey, 1965), our own: its
// angles come from common/math, so the bits are the same on every machine.
// Thread safety: pure functions.
#pragma once

#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling {

/// The mean over chains of (1/draws) sum of (x[i] - m)(x[i + t] - m) over i, m being the chain's
/// own mean, at lags t = 0 .. draws - 1. The error is some 1e-16 of the value at lag 0, at every
/// lag; chains of equal draws contribute exactly 0. REQUIRES: values finite.
std::vector<double> mean_autocovariances(const Chains& draws);

}  // namespace sleight::sampling
