// Arrays of draws of every sort that a diagnostic may meet, for the comparison with R's posterior.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/sampling/diagnostics/chains.h"

namespace sleight::posterior {

struct Array {
  std::string name;  ///< no spaces: number, kind, shape
  sampling::OwnedChains draws;
};

/// The same for the same seed: every kind at many shapes, from 1 to 8 chains of 1 to 2000 draws.
std::vector<Array> arrays(std::uint64_t seed);

}  // namespace sleight::posterior
