// The states of searches between bodies of convex parts: one for each pair of parts.
//
// Thread safety: none.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/distance/closest_points.h"
#include "worker/physics/simulator/pair_graph.h"

namespace sleight::physics {

/// Of one pair of parts.
struct PieceSearch {
  SeparationCache cache;
  Tick next = k_never;  ///< the next tick to look at
};

class PieceSearches {
 public:
  /// The searches of a pair of bodies, all fresh; takes a place for them if the pair has none.
  std::span<PieceSearch> fresh(std::uint32_t& place, std::size_t count) {
    if (place == k_no_search) {
      if (free_.empty()) {
        free_.push_back(static_cast<std::uint32_t>(searches_.size()));
        searches_.emplace_back();
        free_.reserve(searches_.capacity());
      }
      place = free_.back();
      free_.pop_back();
    }
    searches_[place].assign(count, {});
    return searches_[place];
  }

  std::span<PieceSearch> of(std::uint32_t place) { return searches_[place]; }

  void release(std::uint32_t& place) {
    if (place == k_no_search) return;
    free_.push_back(place);
    place = k_no_search;
  }

 private:
  std::vector<std::vector<PieceSearch>> searches_;
  std::vector<std::uint32_t> free_;
};

}  // namespace sleight::physics
