#include "clients/browse/matching.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"

namespace sleight::browse {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// Returns the first open column with the least length.
/// REQUIRES: an open column has a finite length.
std::size_t first_least(const std::vector<double>& lengths, const std::vector<double>& closed) {
  // Use four independent lanes, so that comparisons don't wait for each other.
  constexpr std::size_t k_lanes = 4;
  double least[k_lanes] = {k_infinity, k_infinity, k_infinity, k_infinity};
  const std::size_t size = lengths.size();
  std::size_t i = 1;
  for (; i + k_lanes <= size; i += k_lanes) {
    for (std::size_t lane = 0; lane < k_lanes; ++lane)
      least[lane] = std::min(least[lane], lengths[i + lane] + closed[i + lane]);
  }
  for (; i < size; ++i)
    least[0] = std::min(least[0], lengths[i] + closed[i]);
  const double of_all = std::min({least[0], least[1], least[2], least[3]});
  i = 1;
  while (lengths[i] + closed[i] != of_all)
    ++i;
  return i;
}

}  // namespace

std::span<const std::uint32_t> CheapestMatching::of(std::span<const double> costs,
                                                    std::size_t size) {
  CHECK_EQ(costs.size(), size * size);
  u_.assign(size + 1, 0);
  v_.assign(size + 1, 0);
  row_of_.assign(size + 1, 0);
  came_from_.assign(size + 1, 0);
  shortest_.resize(size + 1);
  closed_.resize(size + 1);
  for (std::size_t row = 1; row <= size; ++row)
    add_row(costs, size, row);
  column_of_.resize(size);
  for (std::size_t column = 1; column <= size; ++column)
    column_of_[row_of_[column] - 1] = static_cast<std::uint32_t>(column - 1);
  return column_of_;
}

/// Matches another row. Keeps cost[row][column] - u[row] - v[column] nonnegative, and 0 for matched
/// pairs.
void CheapestMatching::add_row(std::span<const double> costs, std::size_t size, std::size_t row) {
  // Grow a tree of shortest paths from the row until it reaches a free column.
  std::ranges::fill(shortest_, k_infinity);
  std::ranges::fill(closed_, 0);
  tree_.clear();
  row_of_[0] = row;
  std::size_t column = 0;
  do {
    closed_[column] = k_infinity;
    tree_.push_back(column);
    const std::size_t from = row_of_[column];
    // The arrays don't overlap, so process two columns at a time.
    const double* __restrict const cost = costs.data() + (from - 1) * size;
    const double u = u_[from];
    const double* __restrict const v = v_.data() + 1;
    const double* __restrict const closed = closed_.data() + 1;
    double* __restrict const shortest = shortest_.data() + 1;
    std::uint64_t* __restrict const came_from = came_from_.data() + 1;
    for (std::size_t i = 0; i < size; ++i) {
      const double reduced = cost[i] - u - v[i] + closed[i];
      const double before = shortest[i];
      const std::uint64_t is_shorter = reduced < before ? ~std::uint64_t{0} : 0;
      shortest[i] = reduced < before ? reduced : before;
      came_from[i] = (is_shorter & column) | (~is_shorter & came_from[i]);
    }
    const std::size_t nearest = first_least(shortest_, closed_);
    const double step = shortest_[nearest];
    for (const std::size_t in_tree : tree_) {
      u_[row_of_[in_tree]] += step;
      v_[in_tree] -= step;
    }
    for (double& length : shortest_)
      length -= step;
    column = nearest;
  } while (row_of_[column] != 0);
  while (column != 0) {
    row_of_[column] = row_of_[came_from_[column]];
    column = came_from_[column];
  }
}

}  // namespace sleight::browse
