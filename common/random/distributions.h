// All distributions, and what they have in common.
//
// Idea. A distribution is a small struct of parameters with two functions: draw(stream) gives an
// exact draw, log_density(x) the logarithm of its normalised density. The pair is what a
// Metropolis-Hastings acceptance needs, so both stand together and a test compares them (a
// chi-square of draws against the density's integral). The standard library's distributions are
// never used: their algorithms differ between implementations, and they call libm.
//
// Invariants
//   1. A draw is a function of the parameters and of the stream's words alone, in bits.
//   2. log_density is normalised with respect to the measure that each struct names, and
//      -infinity outside the support. Between draw and density there is no deviation other than
//      rounding and the grid of Stream::uniform, whose effect each struct states.
//   3. Parameters that make no distribution, and NaN as an argument, are bugs: CHECK. What a person
//      typed has been judged before (common/request).
//   4. How many words a draw takes is stated where it is fixed; rejection methods take a random
//      number of them, which is harmless since streams are addressed per iteration.
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
