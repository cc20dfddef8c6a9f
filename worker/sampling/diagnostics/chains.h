// Input of the diagnostics: several chains' draws of one scalar. The chains are equally long.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/base/check.h"

namespace sleight::sampling {

/// A view that owns nothing: draw d of chain c is values[c * draws + d].
/// Functions that take Chains REQUIRE: chains >= 1, draws >= 1, values.size() == chains * draws.
struct Chains {
  std::span<const double> values;
  std::size_t chains = 1;
  std::size_t draws = 0;

  std::span<const double> chain(std::size_t index) const {
    return values.subspan(index * draws, draws);
  }
};

/// Like Chains, but owns the values.
struct OwnedChains {
  std::vector<double> values;
  std::size_t chains = 1;
  std::size_t draws = 0;

  Chains view() const { return {.values = values, .chains = chains, .draws = draws}; }
};

inline void check_shape(const Chains& draws) {
  CHECK_GE(draws.chains, 1U);
  CHECK_GE(draws.draws, 1U);
  CHECK_EQ(draws.values.size(), draws.chains * draws.draws);
}

}  // namespace sleight::sampling
