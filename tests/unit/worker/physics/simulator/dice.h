// Random choices for a test, drawn from a separate stream.
#pragma once

#include <cmath>
#include <cstdint>

#include "common/math/vector.h"
#include "common/random/distributions.h"
#include "common/random/stream.h"

namespace sleight::physics::testing {

using math::Vec3;

struct Dice {
  Dice(std::uint64_t seed, std::uint64_t index)
      : stream({.seed = seed, .purpose = random::Purpose::prior}, index) {}
  std::uint64_t below(std::uint64_t count) {
    return random::UniformInteger{.count = count}.draw(stream);
  }
  bool one_in(std::uint64_t count) { return below(count) == 0; }
  double within(double half) { return random::Uniform{.low = -half, .high = half}.draw(stream); }
  /// Returns a size from low to high. The size's logarithm is uniform.
  double between(double low, double high) { return low * std::pow(high / low, 0.5 + within(0.5)); }
  Vec3 vector_within(double half) {
    const double x = within(half);
    const double y = within(half);
    return {x, y, within(half)};
  }
  random::Stream stream;
};

}  // namespace sleight::physics::testing
