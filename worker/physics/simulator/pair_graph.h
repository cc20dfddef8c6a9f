// The graph of watched pairs, which stores when each pair may collide next.
//
// Each body has a flat list of edges, one for each body whose bounding volume overlaps its own.
// Lists are ranges of a few shared arrays, so that the lists in use occupy few pages of memory. A
// full list moves to a range of twice the capacity. Ids, ticks, change numbers and details are in
// separate arrays. So a search for an id reads one cache line, and the two copies of an edge don't
// store each other's position. If the world has only spheres in flight, there are no details, and
// sixteen edges fill four cache lines.
//
// A pair's prediction is stored in the copy of the body whose motion changed last, because that
// body made the prediction. The partner's copy may still hold an older prediction. Each copy also
// stores the partner's change number at the prediction. If that number has changed since, the copy
// is void.
//
// Invariants
//   1. The same index in all arrays belongs to the same edge.
//   2. One of a pair's two copies holds the prediction for the bodies' current segments.
//   3. The order within a list has no meaning, and no result may depend on it.
//   4. Capacities are first_room_ times a power of two. Each capacity has a chain of free ranges.
//      When a list leaves a range, the range joins this chain, and other lists can reuse it.
// Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
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

struct Prediction {
  Tick tick = k_never;        ///< nothing happens before
  std::uint32_t feature = 0;  ///< which pair of convex pieces collides, if any
  bool certain = false;       ///< collision at `tick`; otherwise the pair must be examined then
};

/// Marks a copy without prediction; never equal to a change number.
inline constexpr std::uint32_t k_void = UINT32_MAX;

/// Further data of an edge. Absent if all bodies are spheres in flight.
struct EdgeDetail {
  std::uint32_t feature = 0;
  std::uint32_t search = k_no_search;  ///< the same in both copies
  bool certain = false;
};

/// Pointers to a body's copy of an edge.
struct PairEdge {
  BodyId other{};
  Tick* tick = nullptr;
  std::uint32_t* other_changes = nullptr;  ///< the other body's change number at the prediction
  EdgeDetail* detail = nullptr;            ///< may be null: feature 0, certain unless never

  void predict(const Prediction& prediction) const {
    *tick = prediction.tick;
    if (detail == nullptr) return;
    detail->feature = prediction.feature;
    detail->certain = prediction.certain;
  }
  Prediction prediction() const {
    if (detail == nullptr) return {.tick = *tick, .certain = *tick != k_never};
    return {.tick = *tick, .feature = detail->feature, .certain = detail->certain};
  }
};

/// All or some edges of a body's list. Valid until the graph changes.
struct PairEdges {
  std::size_t count = 0;
  const BodyId* others = nullptr;
  Tick* ticks = nullptr;
  std::uint32_t* other_changes = nullptr;
  EdgeDetail* details = nullptr;  ///< may be null

  PairEdge operator[](std::size_t i) const {
    return {.other = others[i],
            .tick = ticks + i,
            .other_changes = other_changes + i,
            .detail = details == nullptr ? nullptr : details + i};
  }
  PairEdges from(std::size_t begin, std::size_t some) const {
    return {.count = some,
            .others = others + begin,
            .ticks = ticks + begin,
            .other_changes = other_changes + begin,
            .details = details == nullptr ? nullptr : details + begin};
  }
};

class PairGraph {
 public:
  struct Room {
    std::size_t list = 16;     ///< initial capacity of each list, rounded up to whole cache lines
    std::size_t average = 16;  ///< edges per body for which memory is reserved
    bool details = true;       ///< false: only spheres in flight, whose ticks are certain
  };

  void reset(std::size_t bodies, const Room& room) {
    first_room_ = static_cast<std::uint32_t>((room.list + k_scan - 1) / k_scan * k_scan);
    left_.fill(k_none);
    // When lists move, they leave ranges behind. Together, these ranges are at most as large as all
    // ranges in use.
    const std::size_t edges = bodies * std::max<std::size_t>(first_room_, 2 * room.average);
    others_.reserve(edges);
    ticks_.reserve(edges);
    other_changes_.reserve(edges);
    has_details_ = room.details;
    if (has_details_) details_.reserve(edges);
    lists_.resize(bodies);
    for (List& list : lists_)
      list = {.begin = stretch(0)};
  }

  PairEdges edges_of(BodyId body) {
    const List& list = lists_[body];
    return all().from(list.begin, list.count);
  }
  std::span<const BodyId> others_of(BodyId body) const {
    const List& list = lists_[body];
    return {others_.data() + list.begin, list.count};
  }

  /// Adds a pair at the end of both lists, without prediction.
  void add(BodyId a, BodyId b) {
    append(b, a);
    append(a, b);
  }

  /// Prefetches the first sixteen edges of a body's list.
  void fetch(BodyId body) const {
    const std::uint32_t begin = lists_[body].begin;
    __builtin_prefetch(others_.data() + begin);
    __builtin_prefetch(other_changes_.data() + begin, 1);
    __builtin_prefetch(ticks_.data() + begin, 1);
    __builtin_prefetch(ticks_.data() + begin + 8, 1);
  }

  std::optional<PairEdge> find(BodyId a, BodyId b) {
    const List& list = lists_[a];
    const std::uint32_t place = place_of(list, b);
    if (place >= list.count) return std::nullopt;
    return all()[std::size_t{list.begin} + place];
  }

  /// Removes a pair and returns its search. In each list, the last edge moves to the free place.
  /// REQUIRES: the graph contains the pair.
  std::uint32_t remove(BodyId a, BodyId b) {
    take_out(lists_[b], a);
    return take_out(lists_[a], b);
  }

 private:
  static constexpr std::uint32_t k_none = UINT32_MAX;
  static constexpr std::uint32_t k_scan = 16;
  struct List {
    std::uint32_t begin = 0;  ///< index in all arrays
    std::uint32_t count = 0;
    std::uint32_t doublings = 0;  ///< capacity = first_room_ << doublings
  };

  PairEdges all() {
    return {.count = others_.size(),
            .others = others_.data(),
            .ticks = ticks_.data(),
            .other_changes = other_changes_.data(),
            .details = has_details_ ? details_.data() : nullptr};
  }

  void append(BodyId body, BodyId other) {
    List& list = lists_[body];
    if (list.count == first_room_ << list.doublings) [[unlikely]] {
      move(list);
    }
    const std::size_t at = std::size_t{list.begin} + list.count++;
    others_[at] = other;
    other_changes_[at] = k_void;  // void, whatever its tick
    if (has_details_) details_[at] = {};
  }

  /// Returns a free range whose capacity is the initial one, doubled this many times.
  std::uint32_t stretch(std::uint32_t doublings) {
    std::uint32_t& left = left_[doublings];
    if (left != k_none) {
      const std::uint32_t begin = left;
      left = other_changes_[begin];
      return begin;
    }
    const std::size_t begin = others_.size();
    const std::size_t end = begin + (std::size_t{first_room_} << doublings);
    CHECK_LT(end, std::size_t{k_none});
    others_.resize(end);
    ticks_.resize(end);
    other_changes_.resize(end);
    if (has_details_) details_.resize(end);
    return static_cast<std::uint32_t>(begin);
  }

  void move(List& list) {
    const std::uint32_t to = stretch(list.doublings + 1);
    const auto copy = [&](auto& array) {
      std::copy_n(array.begin() + list.begin, list.count, array.begin() + to);
    };
    copy(others_);
    copy(ticks_);
    copy(other_changes_);
    if (has_details_) copy(details_);
    other_changes_[list.begin] = left_[list.doublings];
    left_[list.doublings] = list.begin;
    list.begin = to;
    ++list.doublings;
  }

  /// Returns the index of another body in a list, or at least list.count if the list doesn't
  /// contain that body. Compares many ids at a time, because the processor can't predict where a
  /// sequential search ends.
  std::uint32_t place_of(const List& list, BodyId other) const {
    const BodyId* ids = others_.data() + list.begin;
    std::uint32_t from = 0;
    for (; from + k_scan <= list.count; from += k_scan) {
      const std::uint32_t bits = equal_bits(ids + from, other);
      if (bits != 0) return from + static_cast<std::uint32_t>(std::countr_zero(bits));
    }
    // A range's length is a multiple of k_scan, so reading beyond the count finds only old ids.
    if (from == list.count) return list.count;
    const std::uint32_t bits = equal_bits(ids + from, other);
    return from + static_cast<std::uint32_t>(std::countr_zero(bits));
  }
  /// Returns one bit for each of k_scan ids: whether the id equals `wanted`.
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

  std::uint32_t take_out(List& list, BodyId other) {
    const std::size_t place = std::size_t{list.begin} + place_of(list, other);
    const std::size_t last = std::size_t{list.begin} + --list.count;
    others_[place] = others_[last];
    ticks_[place] = ticks_[last];
    other_changes_[place] = other_changes_[last];
    if (!has_details_) return k_no_search;
    const std::uint32_t search = details_[place].search;
    details_[place] = details_[last];
    return search;
  }

  std::uint32_t first_room_ = 1;
  std::vector<List> lists_;
  NearVector<BodyId> others_;
  NearVector<Tick> ticks_;  ///< ticks of predictions
  NearVector<std::uint32_t> other_changes_;
  NearVector<EdgeDetail> details_;
  bool has_details_ = true;
  std::array<std::uint32_t, 32> left_{};  ///< by doublings: first free range of the chain
};

}  // namespace sleight::physics
