// Search states for bodies made of convex parts, one state per pair of parts.
//
// Each pair of bodies has a block of states in one array. A released block is reused for a pair
// that needs a block of the same size. Thread safety: none.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/collision/near_places.h"
#include "worker/physics/distance/closest_points.h"

namespace sleight::physics {

inline constexpr std::uint32_t k_no_search = UINT32_MAX;

struct PieceSearch {
  SeparationCache cache;
  PlacesOfPair clear_in = 0;  ///< while the bodies have these places, the parts can't meet
  Tick next = k_never;        ///< the next tick to look at
  std::uint32_t looks = 0;    ///< number of looks so far
  std::uint32_t count = 0;    ///< in a block's first state: the block's size
};

class PieceSearches {
 public:
  void reserve(std::size_t bodies) {
    constexpr std::size_t k_neighbours = 32;
    searches_.reserve(bodies * k_neighbours);
    free_.resize(2);
    for (auto& blocks : free_)
      blocks.reserve(bodies * k_neighbours);
  }

  void clear() {
    searches_.clear();
    for (auto& blocks : free_)
      blocks.clear();
  }

  /// Restarts a pair's searches. If the pair has no block, allocates one. Caches and clear places
  /// stay valid, because only the bodies' motions changed, not their positions.
  std::span<PieceSearch> fresh(std::uint32_t& place, std::size_t count) {
    const bool known = place != k_no_search;
    if (!known) {
      if (free_.size() <= count) free_.resize(count + 1);
      if (free_[count].empty()) {
        place = static_cast<std::uint32_t>(searches_.size());
        searches_.resize(searches_.size() + count);
      } else {
        place = free_[count].back();
        free_[count].pop_back();
      }
    }
    const auto block = std::span(searches_).subspan(place, count);
    for (PieceSearch& search : block) {
      search =
          known ? PieceSearch{.cache = search.cache, .clear_in = search.clear_in} : PieceSearch{};
    }
    block[0].count = static_cast<std::uint32_t>(count);
    return block;
  }

  std::span<PieceSearch> of(std::uint32_t place) {
    return std::span(searches_).subspan(place, searches_[place].count);
  }

  void release(std::uint32_t& place) {
    if (place == k_no_search) return;
    free_[searches_[place].count].push_back(place);
    place = k_no_search;
  }

 private:
  std::vector<PieceSearch> searches_;
  std::vector<std::vector<std::uint32_t>> free_;  ///< first indices of free blocks, by block size
};

}  // namespace sleight::physics
