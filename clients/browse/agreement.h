// Whether two sets of animations differ.
//
// Thread safety: pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sleight::browse {

/// The test of two samples by nearest neighbours (M. Schilling, Journal of the American Statistical
/// Association 81, 1986; with three neighbours).
struct NeighbourTest {
  double share = 0;     ///< of nearest neighbours that are of the same set
  double expected = 0;  ///< mean share where sets are dealt at random
  double p_value = 1;  ///< how often the dealing gives this share or more; at least 1 / (deals + 1)
};
inline constexpr std::size_t k_neighbours = 3;
inline constexpr std::size_t k_deals = 999;

/// Of distances between all, row by row, and the set of each, 0 or 1. The deals are those of a
/// fixed seed. REQUIRES: at least one of each set.
NeighbourTest neighbour_test(std::span<const float> matrix, std::span<const std::uint8_t> set_of);

}  // namespace sleight::browse
