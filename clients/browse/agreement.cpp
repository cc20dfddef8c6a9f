#include "clients/browse/agreement.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "common/base/check.h"

namespace sleight::browse {
namespace {

double pairs(double count) {
  return 0.5 * count * (count - 1);
}

/// SplitMix64 (G. Steele, D. Lea, C. Flood, OOPSLA 2014): enough for dealing.
class Dealer {
 public:
  std::uint64_t below(std::uint64_t bound) {
    // The share by which small numbers are likelier is below bound / 2^64.
    return next() % bound;
  }

 private:
  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }
  std::uint64_t state_ = 0;
};

}  // namespace

double adjusted_rand_index(std::span<const std::size_t> a, std::span<const std::size_t> b) {
  CHECK_EQ(a.size(), b.size());
  std::map<std::size_t, double> of_a;
  std::map<std::size_t, double> of_b;
  std::map<std::pair<std::size_t, std::size_t>, double> of_both;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ++of_a[a[i]];
    ++of_b[b[i]];
    ++of_both[{a[i], b[i]}];
  }
  const auto sum = [](const auto& counts) {
    double total = 0;
    for (const auto& [label, count] : counts)
      total += pairs(count);
    return total;
  };
  const double together_a = sum(of_a);
  const double together_b = sum(of_b);
  const double all = pairs(static_cast<double>(a.size()));
  const double expected = all > 0 ? together_a * together_b / all : 0;
  const double most = 0.5 * (together_a + together_b);
  if (most == expected) return 1;
  return (sum(of_both) - expected) / (most - expected);
}

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
  Dealer dealer;
  std::size_t as_much = 0;
  for (std::size_t deal = 0; deal < k_deals; ++deal) {
    for (std::size_t i = size - 1; i > 0; --i)
      std::swap(dealt[i], dealt[dealer.below(i + 1)]);
    const double other = share(dealt);
    test.expected += other / static_cast<double>(k_deals);
    as_much += other >= test.share ? 1 : 0;
  }
  test.p_value = static_cast<double>(as_much + 1) / static_cast<double>(k_deals + 1);
  return test;
}

}  // namespace sleight::browse
