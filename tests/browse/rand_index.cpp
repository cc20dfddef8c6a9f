#include "tests/browse/rand_index.h"

#include <map>
#include <utility>

#include "common/base/check.h"

namespace sleight::browse::testing {
namespace {

double pairs(double count) {
  return 0.5 * count * (count - 1);
}

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

}  // namespace sleight::browse::testing
