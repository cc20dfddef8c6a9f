// A list of all mistakes. Each entry names the check that catches the mistake, and tells why.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/statistical/mutants/islands/island_checks.h"

namespace sleight::statistical {

template <class M>
struct IslandMutant {
  M mistake;
  const char* name;  ///< Name of the enumerator.
  std::vector<double> (*check)(M mistake, std::uint64_t seed);
  const char* why;  ///< The reason why the check detects the mistake.
};

const std::vector<IslandMutant<Mistake>>& island_mutants();
const std::vector<IslandMutant<PoolMistake>>& pool_mutants();

}  // namespace sleight::statistical
