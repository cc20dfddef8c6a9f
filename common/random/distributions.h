// Includes all distributions, and states their common properties.
//
// Idea. A distribution is a small struct of parameters with two functions. draw(stream) returns an
// exact draw, and log_density(x) returns the logarithm of the normalised density.
// Metropolis-Hastings needs both, so a test compares them (chi-square of draws against the
// density's integral). The standard library's distributions are not used, because their algorithms
// differ between implementations and call libm.
//
// Invariants
//   1. A draw's bits are a function of the parameters and of the stream's words alone.
//   2. log_density is normalised with respect to the measure that each struct names, and -infinity
//      outside the support. Draws have the stated density, except for rounding and for the grid of
//      Stream::uniform. Each struct states the grid's effect.
//   3. Invalid parameters, and NaN as an argument, are bugs that CHECK reports. User input has been
//      validated before (common/request).
//   4. If a struct's draws use a fixed number of words, the struct states that number. Rejection
//      methods may use any number of words, because each iteration has its own stream.
// Thread safety: values; const functions may be called from several threads, each with its Stream.
#pragma once

#include <concepts>

#include "common/random/angular_distributions.h"
#include "common/random/discrete_distributions.h"
#include "common/random/linear_distributions.h"
#include "common/random/stream.h"
#include "common/random/truncated_normal.h"

namespace sleight::random {

template <class T>
concept Distribution = std::copyable<T> && requires(const T& distribution, Stream& stream) {
  { distribution.log_density(distribution.draw(stream)) } -> std::same_as<double>;
};

static_assert(Distribution<Uniform>);
static_assert(Distribution<Normal>);
static_assert(Distribution<TruncatedNormal>);
static_assert(Distribution<UniformDirection2>);
static_assert(Distribution<UniformDirection3>);
static_assert(Distribution<UniformRotation>);
static_assert(Distribution<Bernoulli>);
static_assert(Distribution<UniformInteger>);

}  // namespace sleight::random
