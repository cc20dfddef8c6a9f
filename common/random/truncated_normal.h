// The normal distribution restricted to an interval, accurate in the farthest tails.
//
// Idea. Let a = (low - mean)/sd and b = (high - mean)/sd. If the interval contains 0, draws use
// rejection from the normal, or from the uniform if the interval is short. If the interval is to
// the right of 0, draws use rejection from an exponential. The exponential has the rate of Robert,
// "Simulation of truncated normal variables", Statistics and Computing 5 (1995), section 2. (The
// exponential is restricted to exactly this interval, so the paper's two-sided case is
// unnecessary.) An interval to the left of 0 is mirrored.
//
// In the tail everything is computed from the interval's end nearest to 0: the draw is low + sd t,
// and the density is a function of t = (x - low)/sd. No step subtracts two distribution functions
// that both round to 1, or uses a density that underflows. So [8 sd, infinity) and [1e8 sd, 1e8 sd
// + 1e-7 sd] are as accurate as [-1 sd, 1 sd].
//
// Invariants
//   1. Draws are in [low, high]; at least 4 in 10 proposals are accepted for any parameters.
//   2. log_density is within 1e-13 (1 + |log_density|) of the exact value. The exact value is
//      computed from a and b after their rounding to doubles. The test compares with MPFR.
#pragma once

#include <limits>

#include "common/random/stream.h"

namespace sleight::random {

/// Density per length on the closed interval [low, high]. Either bound may be infinite. REQUIRES:
/// mean finite; sd > 0 and finite; low < high and neither NaN; finite bounds are at most 1e300 sd
/// from the mean, and at least 1e-300 sd apart; low is not +infinity and high not -infinity.
struct TruncatedNormal {
  double mean = 0;
  double sd = 1;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  double draw(Stream& stream) const;
  double log_density(double x) const;
};

}  // namespace sleight::random
