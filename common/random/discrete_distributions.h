// Distributions on yes or no and on whole numbers. What all distributions share is in
// distributions.h. Densities are probabilities.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/random/stream.h"

namespace sleight::random {

/// True with probability p. One word per draw; the probability is met to within 2^-53, and exactly
/// for 0 and 1. REQUIRES: 0 <= p <= 1.
struct Bernoulli {
  double p = 0.5;

  bool draw(Stream& stream) const;
  double log_density(bool x) const;
};

/// One of 0, 1, ..., count - 1, all exactly as likely, by D. Lemire, "Fast random integer
/// generation in an interval", ACM Transactions on Modeling and Computer Simulation 29 (2019),
/// algorithm 5. A draw takes one word, and another with probability below count 2^-64. REQUIRES:
/// count > 0.
struct UniformInteger {
  std::uint64_t count = 1;

  std::uint64_t draw(Stream& stream) const;
  double log_density(std::uint64_t x) const;
};

/// The place of one of some shares, each with its share of their sum as probability; never one of
/// share 0. One word per draw. REQUIRES: shares are at least 0, not all of them 0.
std::size_t draw_by_share(std::span<const double> shares, Stream& stream);

}  // namespace sleight::random
