// The normal distribution restricted to an interval, accurate in the farthest tails.
//
// Idea. Let a = (low - mean)/sd and b = (high - mean)/sd. If the interval contains 0, draws use
// rejection from the normal, or from the uniform if the interval is short. If the interval is to
// the right of 0, draws use rejection from an exponential restricted to the interval, with the rate
// of Robert, "Simulation of truncated normal variables", Statistics and Computing 5 (1995), section
// 2. (Restricting the exponential exactly makes the paper's two-sided case unnecessary.) An
// interval to the left of 0 is mirrored.
//
// In the tail everything is computed from the interval's end nearest to 0: the draw is low + sd t,
// and the density is a function of t = (x - low)/sd. No step subtracts two distribution functions
// that both round to 1, or uses a density that underflows. So [8 sd, infinity) and [1e8 sd, 1e8 sd
// + 1e-7 sd] are as accurate as [-1 sd, 1 sd].
//
// Invariants
//   1. Draws are in [low, high]; at least 4 in 10 proposals are accepted for any parameters.
//   2. log_density is within 1e-13 (1 + |log_density|) of the exact value for a and b as rounded to
//      doubles; the test compares with MPFR.
#pragma once

#include <limits>

#include "common/random/stream.h"

namespace sleight::random {

/// Density per length, on the closed interval [low, high]; either bound may be infinite. REQUIRES:
/// mean finite; sd > 0 and finite; low < high and neither NaN; finite bounds are within 1e300 sd of
/// the mean and 1e-300 sd or more apart; low is not +infinity and high not -infinity.
struct TruncatedNormal {
  double mean = 0;
  double sd = 1;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  double draw(Stream& stream) const;
  double log_density(double x) const;
};

}  // namespace sleight::random
