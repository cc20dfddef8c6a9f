// Who runs next: the chain that is furthest behind, so that all arrive together at what waits for
// all. Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "common/plan/unit.h"

namespace sleight::sampling {

/// A unit of the chain with the fewest scans(), the first among equals; where it has none, of the
/// next one, and so on. Most often the first has one, and the others are not put in order.
template <class Chain, class NextUnit>
std::optional<plan::Unit> unit_of_furthest_behind(std::vector<Chain>& chains,
                                                  const NextUnit& next_unit) {
  const auto scans = [](const Chain* chain) { return chain->scans(); };
  std::vector<Chain*> order;
  order.reserve(chains.size());
  for (Chain& chain : chains)
    order.push_back(&chain);
  const auto least = std::ranges::min_element(order, {}, scans);
  if (least == order.end()) return std::nullopt;
  if (auto unit = next_unit(**least)) return unit;
  order.erase(least);
  std::ranges::stable_sort(order, {}, scans);
  for (Chain* chain : order) {
    if (auto unit = next_unit(*chain)) return unit;
  }
  return std::nullopt;
}

}  // namespace sleight::sampling
