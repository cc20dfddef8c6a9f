// Arrays of draws of every kind that a diagnostic may get. Tests compare our diagnostics of them
// with R's posterior.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::posterior {

struct Array {
  std::string name;  ///< Number, kind and shape, without spaces.
  sampling::OwnedChains draws;
};

/// Returns arrays of every kind in many shapes: 1 to 8 chains, each of 1 to 2000 draws.
std::vector<Array> arrays(std::uint64_t seed);

}  // namespace sleight::posterior
