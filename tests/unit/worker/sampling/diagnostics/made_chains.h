// Seeded chains with known properties.
#pragma once

#include <cstdint>

#include "common/random/linear_distributions.h"
#include "worker/sampling/diagnostics/chains.h"

namespace sleight::sampling::testing {

struct Made {
  std::uint64_t seed = 1;
  std::size_t chains = 4;
  std::size_t draws = 1000;
  double coefficient = 0;  ///< x[i] = coefficient x[i - 1] + a standard normal draw
};

inline OwnedChains made(const Made& how) {
  OwnedChains draws{.values = {}, .chains = how.chains, .draws = how.draws};
  random::Stream stream({.seed = how.seed, .purpose = random::Purpose::prior}, 0);
  for (std::size_t i = 0; i < how.chains * how.draws; ++i) {
    const double before = i % how.draws == 0 ? 0 : draws.values.back();
    draws.values.push_back(how.coefficient * before + random::standard_normal(stream));
  }
  return draws;
}

template <class F>
OwnedChains changed(OwnedChains draws, const F& f) {
  for (std::size_t i = 0; i < draws.values.size(); ++i)
    draws.values[i] = f(draws.values[i], i / draws.draws);
  return draws;
}

}  // namespace sleight::sampling::testing
