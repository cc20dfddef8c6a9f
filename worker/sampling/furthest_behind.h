// Who runs next: the chain that is furthest behind, so that all arrive together at what waits for
// all. Thread safety: pure functions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

namespace sleight::sampling {

/// What `next` has of the chain with the fewest scans(), the first among equals; where that is
/// nothing, of the next one, and so on. Most often the first has something, and the others are not
/// put in order.
template <class Chain, class Next>
auto next_of_furthest_behind(std::vector<Chain>& chains, const Next& next)
    -> decltype(next(chains.front())) {
  const auto scans = [](const Chain* chain) { return chain->scans(); };
  std::vector<Chain*> order;
  order.reserve(chains.size());
  for (Chain& chain : chains)
    order.push_back(&chain);
  const auto least = std::ranges::min_element(order, {}, scans);
  if (least == order.end()) return std::nullopt;
  if (auto found = next(**least)) return found;
  order.erase(least);
  std::ranges::stable_sort(order, {}, scans);
  for (Chain* chain : order) {
    if (auto found = next(*chain)) return found;
  }
  return std::nullopt;
}

}  // namespace sleight::sampling
