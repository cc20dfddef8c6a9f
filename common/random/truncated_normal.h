// The normal distribution restricted to an interval, good in the farthest tails.
//
// Idea. With a = (low - mean)/sd and b = (high - mean)/sd, three cases. An interval that holds 0:
// rejection from the normal, or from the uniform when the interval is short. An interval to the
// right of 0: rejection from an exponential that is itself restricted to the interval, with the
// rate of C. Robert, "Simulation of truncated normal variables", Statistics and Computing 5 (1995),
// section 2 (restricting the exponential exactly makes his separate two-sided case unnecessary). An
// interval to the left of 0: its mirror image.
//
// In the tail everything is computed from the near end of the interval: the draw is low + sd t and
// the density a function of t = (x - low)/sd. No step forms a difference of two distribution
// functions that both round to 1, or a density that underflows, so [8 sd, infinity) and
// [1e8 sd, 1e8 sd + 1e-7 sd] are as good as [-1 sd, 1 sd].
//
// Invariants
//   1. Draws lie in [low, high]; at least 4 in 10 proposals are accepted for any parameters.
//   2. log_density is within 1e-13 (1 + |log_density|) of exact, given a and b as rounded to
//      doubles; the test compares with MPFR.
#pragma once

#include <limits>

#include "common/random/stream.h"

namespace sleight::random {

/// Density with respect to length, on the closed interval [low, high]; either bound may be
/// infinite. REQUIRES: mean finite; sd > 0 and finite; low < high and neither NaN; finite bounds
/// are within 1e300 sd of the mean and 1e-300 sd or more apart; low is not +infinity and high not
/// -infinity.
struct TruncatedNormal {
  double mean = 0;
  double sd = 1;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  double draw(Stream& stream) const;
  double log_density(double x) const;
};

}  // namespace sleight::random
