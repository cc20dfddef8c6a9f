// Distributions on booleans and whole numbers, whose densities are probabilities.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/random/stream.h"

namespace sleight::random {

/// True with probability p, within 2^-53. One word per draw. REQUIRES: 0 <= p <= 1.
struct Bernoulli {
  double p = 0.5;

  bool draw(Stream& stream) const;
  double log_density(bool x) const;
};

/// Exactly uniform on 0, 1, ..., count - 1. Source: Lemire, "Fast random integer generation in an
/// interval", ACM Transactions on Modeling and Computer Simulation 29 (2019), algorithm 5. A draw
/// uses one word, and sometimes further ones. After each word, the probability of another is below
/// count / 2^64. REQUIRES: count > 0.
struct UniformInteger {
  std::uint64_t count = 1;

  std::uint64_t draw(Stream& stream) const;
  double log_density(std::uint64_t x) const;
};

/// Draws an index with a probability proportional to the index's share. One word per draw.
/// REQUIRES: shares >= 0, not all 0.
std::size_t draw_by_share(std::span<const double> shares, Stream& stream);

}  // namespace sleight::random
