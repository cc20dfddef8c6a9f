// A test whether two sets of animations differ. Thread safety: pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sleight::browse {

/// The result of Schilling's two-sample test by nearest neighbours (Journal of the American
/// Statistical Association 81, 1986), with three neighbours.
struct NeighbourTest {
  double share = 0;     ///< share of nearest neighbours that belong to the same set
  double expected = 0;  ///< mean share with random sets
  double p_value = 1;   ///< share of deals with this share or more; at least 1 / (deals + 1)
};
inline constexpr std::size_t k_neighbours = 3;
inline constexpr std::size_t k_deals = 999;

/// `matrix`: distances between all animations, row by row. `set_of`: each animation's set, 0 or 1.
/// The random permutations use a fixed seed. REQUIRES: at least one animation in each set.
NeighbourTest neighbour_test(std::span<const float> matrix, std::span<const std::uint8_t> set_of);

}  // namespace sleight::browse
