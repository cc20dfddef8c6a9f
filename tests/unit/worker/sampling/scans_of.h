// Scans of solutions, for tests.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "worker/sampling/solutions.h"

namespace sleight::sampling {

/// The first satisfied scans of all lineages, ascending.
inline std::vector<std::uint64_t> scans_of(const Solutions& solutions) {
  std::vector<std::uint64_t> scans;
  for (const auto& first : solutions.between(0, std::numeric_limits<std::uint64_t>::max()))
    scans.push_back(first.scan);
  return scans;
}

}  // namespace sleight::sampling
