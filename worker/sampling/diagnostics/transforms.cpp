#include "worker/sampling/diagnostics/transforms.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/math/normal_quantile.h"

namespace sleight::sampling {

double mean_of(std::span<const double> values) {
  CHECK(!values.empty());
  const auto count = static_cast<double>(values.size());
  const double rough = std::accumulate(values.begin(), values.end(), 0.0) / count;
  // Correct the first pass's rounding with Neumaier's compensation (1974).
  double rest = 0;
  double lost = 0;
  for (const double value : values) {
    const double term = value - rough;
    const double sum = rest + term;
    lost += std::fabs(rest) >= std::fabs(term) ? (rest - sum) + term : (term - sum) + rest;
    rest = sum;
  }
  return rough + (rest + lost) / count;
}

std::vector<double> chain_means(const Chains& draws) {
  check_shape(draws);
  std::vector<double> means;
  means.reserve(draws.chains);
  for (std::size_t c = 0; c < draws.chains; ++c) {
    const auto chain = draws.chain(c);
    means.push_back(std::accumulate(chain.begin(), chain.end(), 0.0) /
                    static_cast<double>(draws.draws));
  }
  return means;
}

double variance_of(std::span<const double> values) {
  if (values.size() == 1) return std::numeric_limits<double>::quiet_NaN();
  const double mean = mean_of(values);
  double sum = 0;
  for (const double value : values)
    sum += (value - mean) * (value - mean);
  return sum / static_cast<double>(values.size() - 1);
}

bool is_degenerate(std::span<const double> values) {
  if (!std::ranges::all_of(values, [](double value) { return std::isfinite(value); })) return true;
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  return *greatest - *least < std::numeric_limits<double>::epsilon();
}

double median_of(std::span<const double> values) {
  CHECK(!values.empty());
  if (std::ranges::any_of(values, [](double value) { return std::isnan(value); }))
    return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted(values.begin(), values.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  if (sorted.size() % 2 == 1) return *middle;
  const double below = *std::max_element(sorted.begin(), middle);
  return below / 2 + *middle / 2;
}

double quantile_of(std::span<const double> values, double probability) {
  CHECK(!values.empty());
  CHECK(probability >= 0 && probability <= 1);
  // Interpolate exactly as R does, because draws are compared with the result.
  const double place = 1 + static_cast<double>(values.size() - 1) * probability;
  const double floor = std::floor(place);
  const double share = place - floor;
  std::vector<double> sorted(values.begin(), values.end());
  const auto low = sorted.begin() + static_cast<std::ptrdiff_t>(floor) - 1;
  std::nth_element(sorted.begin(), low, sorted.end());
  if (share <= 0) return *low;
  const double high = *std::min_element(low + 1, sorted.end());
  if (high == *low) return high;
  return (1 - share) * *low + share * high;
}

OwnedChains split_in_halves(const Chains& draws) {
  check_shape(draws);
  const std::size_t half = draws.draws / 2;
  OwnedChains halves;
  halves.values.reserve(draws.values.size());
  if (half == 0) {
    halves = {.values = {draws.values.begin(), draws.values.end()},
              .chains = draws.chains,
              .draws = draws.draws};
    return halves;
  }
  halves.chains = half == 1 ? 2 : 2 * draws.chains;
  halves.draws = half == 1 ? draws.chains : half;
  for (const bool last : {false, true}) {
    for (std::size_t c = 0; c < draws.chains; ++c) {
      const auto part = last ? draws.chain(c).last(half) : draws.chain(c).first(half);
      halves.values.insert(halves.values.end(), part.begin(), part.end());
    }
  }
  return halves;
}

OwnedChains normal_scores(const Chains& draws) {
  check_shape(draws);
  OwnedChains scores{.values = {draws.values.begin(), draws.values.end()},
                     .chains = draws.chains,
                     .draws = draws.draws};
  const std::span<const double> values = draws.values;
  if (std::ranges::any_of(values, [](double value) { return std::isnan(value); })) return scores;

  // Process the draws in ascending order, one group of equal draws after another.
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  const auto count = static_cast<double>(values.size());
  std::size_t begin = 0;
  while (begin < order.size()) {
    std::size_t end = begin + 1;
    while (end < order.size() && values[order[end]] == values[order[begin]])
      ++end;
    const double rank = static_cast<double>(begin + 1 + end) / 2;
    const double score = math::normal_quantile((rank - 0.375) / (count + 0.25));
    for (; begin < end; ++begin)
      scores.values[order[begin]] = score;
  }
  return scores;
}

OwnedChains folded(const Chains& draws) {
  check_shape(draws);
  const double median = median_of(draws.values);
  OwnedChains distances{.values = {}, .chains = draws.chains, .draws = draws.draws};
  distances.values.reserve(draws.values.size());
  for (const double value : draws.values)
    distances.values.push_back(std::fabs(value - median));
  return distances;
}

}  // namespace sleight::sampling
