// Distributions on the line: uniform and normal (truncated_normal.h has the truncated normal).
// Units: x and the parameters share one unit. Densities are per length in the unit of x.
#pragma once

#include "common/random/stream.h"

namespace sleight::random {

/// Uniform on [low, high]. Draws are on a grid of 2^52 midpoints, rounded to doubles. One word per
/// draw. REQUIRES: low < high, and high - low finite.
struct Uniform {
  double low = 0;
  double high = 1;

  double draw(Stream& stream) const;
  double log_density(double x) const;
};

/// Normal, by the method of Box and Muller, "A note on the generation of random normal deviates"
/// (1958), cosine only: sqrt(-2 log u) cos(2 pi v). Table methods would be faster. With this
/// method, a draw always uses two words, and its bits depend only on three functions of
/// common/math. The grid of u limits draws to 8.58 sd; the probability beyond 8.58 sd is 1e-17.
/// REQUIRES: mean finite; sd > 0 and finite.
struct Normal {
  double mean = 0;
  double sd = 1;

  double draw(Stream& stream) const;
  double log_density(double x) const;
};

/// A normal log density, precomputed for many arguments. The bits equal Normal::log_density's.
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
