// Figures of made-up data, similar to Sleight's, for the tests and for viewing.
#pragma once

#include <cstdint>
#include <vector>

#include "clients/plot/figure.h"

namespace sleight::plot {

/// A linear congruential generator, the same on every machine.
class MadeUp {
 public:
  explicit MadeUp(std::uint64_t seed) : state_(seed) {}
  double uniform() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  /// Roughly normal: a sum of twelve uniforms.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i)
      sum += uniform();
    return sum;
  }

 private:
  std::uint64_t state_;
};

/// Returns a figure like the thesis's figure 2.4: the landing position with its band over
/// iterations, and log p below.
Figure landing_figure();

/// Returns a figure like the thesis's figure 2.3: three bouncing paths with normals and a target.
Figure paths_figure();

/// Hostile input: gaps, infinities, huge and constant values, markup in labels.
Figure hostile_figure();

}  // namespace sleight::plot
