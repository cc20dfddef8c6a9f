#include "tests/posterior/arrays.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "common/math/elementary.h"
#include "common/random/linear_distributions.h"
#include "tests/support/numbers.h"

namespace sleight::posterior {
namespace {

using random::standard_normal;
using random::Stream;
using sampling::OwnedChains;

constexpr double k_pi = 3.14159265358979323846;

/// Fills an array of given shape, chain by chain, from one stream.
using Fill = void (*)(OwnedChains&, Stream&);

std::size_t at_random(const OwnedChains& draws, Stream& stream) {
  return stream.bits() % draws.values.size();
}

void independent(OwnedChains& draws, Stream& stream) {
  for (double& value : draws.values)
    value = standard_normal(stream);
}

void autoregressive(OwnedChains& draws, Stream& stream, double coefficient) {
  independent(draws, stream);
  for (std::size_t i = 0; i < draws.values.size(); ++i)
    if (i % draws.draws != 0) draws.values[i] += coefficient * draws.values[i - 1];
}

void shift_chains(OwnedChains& draws, double step) {
  for (std::size_t i = 0; i < draws.values.size(); ++i)
    draws.values[i] += step * static_cast<double>(i / draws.draws);
}

void integers(OwnedChains& draws, Stream& stream, double spread) {
  autoregressive(draws, stream, 0.5);
  for (double& value : draws.values)
    value = std::floor(spread * value);
}

struct Kind {
  const char* name;
  Fill fill;
};

constexpr auto k_kinds = std::to_array<Kind>({
    {"independent", independent},
    {"offset", [](OwnedChains& d, Stream& s) { independent(d, s); for (double& v : d.values) v = 1e6 + v; }},
    {"small", [](OwnedChains& d, Stream& s) { independent(d, s); for (double& v : d.values) v *= 1e-9; }},
    {"sticky", [](OwnedChains& d, Stream& s) { autoregressive(d, s, 0.9); }},
    {"very_sticky", [](OwnedChains& d, Stream& s) { autoregressive(d, s, 0.995); }},
    {"antithetic", [](OwnedChains& d, Stream& s) { autoregressive(d, s, -0.6); }},
    {"very_antithetic", [](OwnedChains& d, Stream& s) { autoregressive(d, s, -0.97); }},
    {"shifted", [](OwnedChains& d, Stream& s) { independent(d, s); shift_chains(d, 0.7); }},
    {"shifted_sticky", [](OwnedChains& d, Stream& s) { autoregressive(d, s, 0.7); shift_chains(d, 3); }},
    {"scaled_chains", [](OwnedChains& d, Stream& s) {
       independent(d, s);
       for (std::size_t i = 0; i < d.values.size(); ++i)
         d.values[i] *= 1 + static_cast<double>(i / d.draws);
     }},
    {"trend", [](OwnedChains& d, Stream& s) {
       independent(d, s);
       for (std::size_t i = 0; i < d.values.size(); ++i)
         d.values[i] += 0.01 * static_cast<double>(i % d.draws);
     }},
    {"cauchy", [](OwnedChains& d, Stream& s) {
       for (double& v : d.values) v = math::tan(k_pi * (s.uniform() - 0.5));
     }},
    {"sticky_exponential", [](OwnedChains& d, Stream& s) {
       autoregressive(d, s, 0.8);
       for (double& v : d.values) v = math::exp(2 * v);
     }},
    {"integers", [](OwnedChains& d, Stream& s) { integers(d, s, 3); }},
    {"few_integers", [](OwnedChains& d, Stream& s) { integers(d, s, 0.8); }},
    {"two_values", [](OwnedChains& d, Stream& s) { for (double& v : d.values) v = s.uniform() < 0.3 ? 1 : 0; }},
    {"rare_value", [](OwnedChains& d, Stream& s) { for (double& v : d.values) v = s.uniform() < 0.02 ? 1 : 0; }},
    {"repeated", [](OwnedChains& d, Stream& s) {
       independent(d, s);
       for (std::size_t i = 0; i < d.values.size(); ++i)
         if (i % d.draws != 0 && s.uniform() < 0.7) d.values[i] = d.values[i - 1];
     }},
    {"constant", [](OwnedChains& d, Stream& s) { const double v = s.uniform(); for (double& x : d.values) x = v; }},
    {"nearly_constant", [](OwnedChains& d, Stream& s) { for (double& v : d.values) v = 1e-17 * s.uniform(); }},
    {"constant_chains", [](OwnedChains& d, Stream&) {
       for (std::size_t i = 0; i < d.values.size(); ++i)
         d.values[i] = 0.1 * static_cast<double>(1 + i / d.draws);
     }},
    {"one_constant_chain", [](OwnedChains& d, Stream& s) {
       independent(d, s);
       for (std::size_t i = 0; i < d.draws; ++i)
         d.values[i] = 0.3;
     }},
    {"one_nan", [](OwnedChains& d, Stream& s) { independent(d, s); d.values[at_random(d, s)] = k_nan; }},
    {"middle_nan", [](OwnedChains& d, Stream& s) { independent(d, s); d.values[d.draws / 2] = k_nan; }},
    {"one_infinite", [](OwnedChains& d, Stream& s) { independent(d, s); d.values[at_random(d, s)] = k_infinity; }},
    {"middle_infinite", [](OwnedChains& d, Stream& s) { independent(d, s); d.values[d.draws / 2] = -k_infinity; }},
    {"many_infinite", [](OwnedChains& d, Stream& s) {
       independent(d, s);
       for (double& v : d.values)
         if (s.uniform() < 0.6) v = s.uniform() < 0.9 ? -k_infinity : k_infinity;
     }},
    {"all_nan", [](OwnedChains& d, Stream&) { for (double& v : d.values) v = k_nan; }},
    {"all_infinite", [](OwnedChains& d, Stream&) { for (double& v : d.values) v = k_infinity; }},
});

/// All short lengths, and some longer lengths: powers of two, powers of two plus one, primes, and
/// others.
constexpr auto k_lengths = std::to_array<std::size_t>(
    {1,  2,  3,  4,  5,  6,  7,  8,   9,   10,  11,  12,  13,  14,  16,   17,   19,   23,
     25, 32, 37, 50, 64, 65, 99, 100, 128, 200, 333, 500, 501, 800, 1000, 1024, 1999, 2000});
constexpr std::size_t k_shapes_of_a_kind = 14;

}  // namespace

std::vector<Array> arrays(std::uint64_t seed) {
  std::vector<Array> all;
  for (const Kind& kind : k_kinds) {
    for (std::size_t i = 0; i < k_shapes_of_a_kind; ++i) {
      const std::size_t number = all.size();
      Stream stream({.seed = seed, .purpose = random::Purpose::prior}, number);
      // 13 is coprime to the number of lengths, so a kind's arrays have different lengths.
      OwnedChains draws{.values = {},
                        .chains = 1 + stream.bits() % 8,
                        .draws = k_lengths[number * 13 % k_lengths.size()]};
      draws.values.resize(draws.chains * draws.draws);
      kind.fill(draws, stream);
      all.push_back(
          {.name = fmt::format("{}_{}_{}x{}", number, kind.name, draws.chains, draws.draws),
           .draws = std::move(draws)});
    }
  }
  return all;
}

}  // namespace sleight::posterior
