// Each mistake, the check that catches it, and why that one sees it.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/statistical/mutants/islands/island_checks.h"

namespace sleight::statistical {

template <class M>
struct IslandMutant {
  M mistake;
  const char* name;  ///< of the enumerator
  std::vector<double> (*check)(M mistake, std::uint64_t seed);
  const char* why;  ///< the check sees it
};

const std::vector<IslandMutant<Mistake>>& island_mutants();
const std::vector<IslandMutant<PoolMistake>>& pool_mutants();

}  // namespace sleight::statistical
