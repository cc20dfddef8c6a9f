// Distributions on the line: uniform and normal. What all distributions share, and the
// meaning of "exact", is in distributions.h; the truncated normal has its own header.
//
// Units: x and the parameters share one unit. Densities are with respect to
// length in that unit.
#pragma once

#include "common/random/stream.h"

namespace sleight::random {

/// On the closed interval [low, high]. One word per draw; values lie on a grid of 2^52 midpoints,
/// rounded to doubles.
/// REQUIRES: low < high, and high - low finite.
struct Uniform {
  double low = 0;
  double high = 1;

  double draw(Stream& stream) const;
  double log_density(double x) const;
};

/// By the method of G. Box and M. Muller, "A note on the generation of random normal deviates"
/// (1958), the cosine alone: sqrt(-2 log u) cos(2 pi v). Chosen over faster table methods because a
/// draw takes two words always and its bits rest on three functions of common/math. The grid of u
/// bounds draws to 8.58 sd; the mass beyond is 1e-17.
/// REQUIRES: mean finite; sd > 0 and finite.
struct Normal {
  double mean = 0;
  double sd = 1;

  double draw(Stream& stream) const;
  double log_density(double x) const;
};

/// The log density of a normal distribution for many numbers: log_density's, bit for bit, for less.
class NormalLogDensity {
 public:
  explicit NormalLogDensity(const Normal& normal);
  double operator()(double x) const;

 private:
  Normal normal_;
  double log_sd_;
};

/// A draw from Normal{0, 1}.
double standard_normal(Stream& stream);

}  // namespace sleight::random
