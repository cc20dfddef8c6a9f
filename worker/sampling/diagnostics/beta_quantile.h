// The beta distribution's quantile function, with the same bits on every processor.
//
// Method: the density in the saddle-point form, which loses no digits for large parameters
// (C. Loader, "Fast and accurate computation of binomial probabilities", 2000); the distribution
// function by the continued fraction 8.17.22 of the NIST Digital Library of Mathematical Functions;
// its root by Newton's method inside a shrinking bracket.
// Thread safety: pure functions.
#pragma once

namespace sleight::sampling {

/// Of a variable on [0, 1] with density proportional to x^(a-1) (1-x)^(b-1).
struct Beta {
  double a = 1;
  double b = 1;
};

/// The x below which it falls with the given probability, within 1e-12 x + 1e-16.
/// REQUIRES: a and b at least 1, at most 1e12; probability in [0.01, 0.99]: the density's form
/// loses digits where x is far smaller than the mean.
double beta_quantile(const Beta& distribution, double probability);

}  // namespace sleight::sampling
