// Which pairs of bodies are watched, and when each may collide next.
//
// Each body has a flat list of edges, one for each body whose bounding volume overlaps its own. All
// lists are stretches of one array, close together so that few pages of memory hold those that a
// simulation reads; one that is full moves into a stretch of twice the room. Ids lie apart from the
// rest, so that a search for one of them reads a cache line, and the two copies of an edge needn't
// know one another's place. A pair's prediction is in the copy of the body that made it, the one
// that changed its motion last. The other copy may hold an older prediction, which stays there: it
// carries the partner's number of changes at that time, and is void if the partner has changed
// since.
//
// Invariants
//   1. others_of(body)[i] is the id in edges_of(body)[i].other.
//   2. One of a pair's copies holds the prediction for the two bodies' present segments.
//   3. The order within a list says nothing; no result may depend on it.
//   4. Rooms are a power of two times the first one. A stretch that its list has left is in the
//      chain of those with its room, so that the next list which needs as much takes it.
// Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "common/base/check.h"
#include "worker/physics/collision/piece_searches.h"
#include "worker/physics/event/event.h"
#include "worker/physics/simulator/near_allocator.h"

namespace sleight::physics {

/// What is predicted of a pair.
struct Prediction {
  Tick tick = k_never;        ///< nothing happens before
  std::uint32_t feature = 0;  ///< which of the pair's convex pieces meet, if they do
  bool certain = false;       ///< the collision is at `tick`; else the pair must be examined then
};

/// Never a number of changes: a copy that has no prediction.
inline constexpr std::uint32_t k_void = UINT32_MAX;

/// Half a cache line.
struct alignas(32) PairEdge {
  Tick tick = k_never;  ///< of the prediction, as are `feature` and `certain`
  std::uint32_t feature = 0;
  std::uint32_t other = 0;
  std::uint32_t other_changes = k_void;  ///< the other body's, when this was predicted
  std::uint32_t search = k_no_search;    ///< the same in both copies
  bool certain = false;

  void predict(const Prediction& prediction) {
    tick = prediction.tick;
    feature = prediction.feature;
    certain = prediction.certain;
  }
};
static_assert(sizeof(PairEdge) == 32);

class PairGraph {
 public:
  struct Room {
    std::size_t list = 16;     ///< edges of each list before it moves, rounded up to whole lines
    std::size_t average = 16;  ///< edges per body before anything is allocated
  };

  void reset(std::size_t bodies, const Room& room) {
    first_room_ = static_cast<std::uint32_t>((room.list + k_scan - 1) / k_scan * k_scan);
    left_.fill(k_none);
    // Lists that move leave their stretches behind, which are at most as much as all that is in
    // use.
    edges_.reserve(bodies * std::max<std::size_t>(first_room_, 2 * room.average));
    others_.reserve(edges_.capacity());
    lists_.resize(bodies);
    for (List& list : lists_)
      list = {.begin = stretch(0)};
  }

  std::span<PairEdge> edges_of(std::uint32_t body) {
    const List& list = lists_[body];
    return {edges_.data() + list.begin, list.count};
  }
  std::span<const BodyId> others_of(std::uint32_t body) const {
    const List& list = lists_[body];
    return {others_.data() + list.begin, list.count};
  }

  /// Adds a pair and returns a's copy, valid until the next change.
  PairEdge& add(std::uint32_t a, std::uint32_t b) {
    append(b, a);
    return append(a, b);
  }

  /// A hint that a body's list is read soon.
  void fetch(std::uint32_t body) const { __builtin_prefetch(others_.data() + lists_[body].begin); }

  /// a's copy of the pair's edge; null if there is none.
  PairEdge* find(std::uint32_t a, std::uint32_t b) {
    const List& list = lists_[a];
    const std::uint32_t place = place_of(list, b);
    return place < list.count ? &edges_[std::size_t{list.begin} + place] : nullptr;
  }

  /// Removes a pair and returns its search; the last edges of the two lists take the places.
  /// REQUIRES: it is there.
  std::uint32_t remove(std::uint32_t a, std::uint32_t b) {
    take_out(lists_[b], a);
    return take_out(lists_[a], b);
  }

 private:
  static constexpr std::uint32_t k_none = UINT32_MAX;
  static constexpr std::uint32_t k_scan = 16;
  struct List {
    std::uint32_t begin = 0;  ///< in edges_ and others_
    std::uint32_t count = 0;
    std::uint32_t doublings = 0;  ///< of the first room
  };

  PairEdge& append(std::uint32_t body, std::uint32_t other) {
    List& list = lists_[body];
    if (list.count == first_room_ << list.doublings) [[unlikely]] {
      move(list);
    }
    const std::size_t at = std::size_t{list.begin} + list.count++;
    others_[at] = {other};
    return edges_[at] = {.other = other};
  }

  /// A stretch that no list has, with as many doublings of the first room.
  std::uint32_t stretch(std::uint32_t doublings) {
    std::uint32_t& left = left_[doublings];
    if (left != k_none) {
      const std::uint32_t begin = left;
      left = edges_[begin].other;
      return begin;
    }
    const std::size_t begin = edges_.size();
    const std::size_t end = begin + (std::size_t{first_room_} << doublings);
    CHECK_LT(end, std::size_t{k_none});
    edges_.resize(end);
    others_.resize(end);
    return static_cast<std::uint32_t>(begin);
  }

  void move(List& list) {
    const std::uint32_t to = stretch(list.doublings + 1);
    std::copy_n(edges_.begin() + list.begin, list.count, edges_.begin() + to);
    std::copy_n(others_.begin() + list.begin, list.count, others_.begin() + to);
    edges_[list.begin].other = left_[list.doublings];
    left_[list.doublings] = list.begin;
    list.begin = to;
    ++list.doublings;
  }

  /// Where in a list another body is; at least its count if it isn't there. Many ids at a time: the
  /// processor can't guess where a search of one at a time ends.
  std::uint32_t place_of(const List& list, std::uint32_t other) const {
    const BodyId* ids = others_.data() + list.begin;
    std::uint32_t from = 0;
    for (; from + k_scan <= list.count; from += k_scan) {
      const std::uint32_t bits = equal_bits(ids + from, other);
      if (bits != 0) return from + static_cast<std::uint32_t>(std::countr_zero(bits));
    }
    // Stretches are whole multiples of k_scan: beyond the count are ids of the past.
    if (from == list.count) return list.count;
    const std::uint32_t bits = equal_bits(ids + from, other);
    return from + static_cast<std::uint32_t>(std::countr_zero(bits));
  }
  /// Which of k_scan ids are this one.
  static std::uint32_t equal_bits(const BodyId* ids, std::uint32_t wanted) {
    std::uint32_t bits = 0;
#if defined(__SSE2__)
    const __m128i all = _mm_set1_epi32(static_cast<int>(wanted));
    for (std::uint32_t i = 0; i < k_scan; i += 4) {
      const __m128i four = _mm_load_si128(reinterpret_cast<const __m128i*>(ids + i));
      const int equal = _mm_movemask_ps(_mm_castsi128_ps(_mm_cmpeq_epi32(four, all)));
      bits |= static_cast<std::uint32_t>(equal) << i;
    }
#else
    for (std::uint32_t i = 0; i < k_scan; ++i)
      bits |= static_cast<std::uint32_t>(ids[i].value == wanted) << i;
#endif
    return bits;
  }

  std::uint32_t take_out(List& list, std::uint32_t other) {
    const std::size_t place = std::size_t{list.begin} + place_of(list, other);
    const std::size_t last = std::size_t{list.begin} + --list.count;
    const std::uint32_t search = edges_[place].search;
    edges_[place] = edges_[last];
    others_[place] = others_[last];
    return search;
  }

  std::uint32_t first_room_ = 1;
  std::vector<List> lists_;
  NearVector<PairEdge> edges_;
  NearVector<BodyId> others_;
  std::array<std::uint32_t, 32> left_{};  ///< by doublings: the first stretch that a list has left
};

}  // namespace sleight::physics
