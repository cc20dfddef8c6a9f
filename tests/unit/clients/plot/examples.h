// Figures of made-up data, for the tests and for viewing. They resemble Sleight's figures.
#pragma once

#include <cstdint>
#include <vector>

#include "clients/plot/figure.h"

namespace sleight::plot {

/// A linear congruential generator, which gives the same numbers on every machine.
class MadeUp {
 public:
  explicit MadeUp(std::uint64_t seed) : state_(seed) {}
  double uniform() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  /// Returns a sum of twelve uniform numbers, minus 6. The distribution is almost normal.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i)
      sum += uniform();
    return sum;
  }

 private:
  std::uint64_t state_;
};

/// Returns a figure like figure 2.4 of the thesis. The upper panel shows the landing position and
/// its band over iterations. The lower panel shows log p.
Figure landing_figure();

/// Returns a figure like figure 2.3 of the thesis: three bouncing paths, their normals and a
/// target.
Figure paths_figure();

/// Returns a figure of hostile input: gaps, infinities, huge and constant values, and labels that
/// contain markup.
Figure hostile_figure();

}  // namespace sleight::plot
