#include "clients/browse/agreement.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"

namespace sleight::browse {
namespace {

constexpr std::uint64_t k_seed = 0;

}  // namespace

NeighbourTest neighbour_test(std::span<const float> matrix, std::span<const std::uint8_t> set_of) {
  const std::size_t size = set_of.size();
  CHECK_EQ(matrix.size(), size * size);
  const std::size_t neighbours = std::min(k_neighbours, size - 1);
  std::vector<std::size_t> nearest;
  for (std::size_t point = 0; point < size; ++point) {
    std::vector<std::pair<float, std::size_t>> others;
    for (std::size_t other = 0; other < size; ++other) {
      if (other != point) others.emplace_back(matrix[point * size + other], other);
    }
    std::ranges::partial_sort(others, others.begin() + static_cast<std::ptrdiff_t>(neighbours));
    for (std::size_t i = 0; i < neighbours; ++i)
      nearest.push_back(others[i].second);
  }
  const auto share = [&](std::span<const std::uint8_t> sets) {
    std::size_t same = 0;
    for (std::size_t i = 0; i < nearest.size(); ++i)
      same += sets[i / neighbours] == sets[nearest[i]] ? 1 : 0;
    return static_cast<double>(same) / static_cast<double>(nearest.size());
  };
  NeighbourTest test{.share = share(set_of)};
  std::vector<std::uint8_t> dealt(set_of.begin(), set_of.end());
  std::size_t as_much = 0;
  for (std::uint64_t deal = 0; deal < k_deals; ++deal) {
    random::Stream stream({.seed = k_seed, .purpose = random::Purpose::resampling}, deal);
    for (std::size_t i = size - 1; i > 0; --i)
      std::swap(dealt[i], dealt[random::UniformInteger{.count = i + 1}.draw(stream)]);
    const double other = share(dealt);
    test.expected += other / static_cast<double>(k_deals);
    as_much += other >= test.share ? 1 : 0;
  }
  test.p_value = static_cast<double>(as_much + 1) / static_cast<double>(k_deals + 1);
  return test;
}

}  // namespace sleight::browse
