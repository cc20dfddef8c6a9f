// Which pairs of bodies are watched, and when each may collide next.
//
// Each body has a flat list of edges, one for each body whose bounding volume overlaps its own. All
// lists are stretches of one array, close together so that few pages of memory hold those that a
// simulation reads; one that is full moves into a stretch of twice the room. The
// two copies of an edge know one another's place. A pair's prediction is in the copy of the body
// that made it, the one that changed its motion last; the other copy may hold an older one, which
// nobody removes: it carries the number of changes that the partner had made by then, and is void
// if the partner has changed since.
//
// Invariants
//   1. mirror: edges_of(e.other)[e.mirror] is the other copy of e.
//   2. others_of(body)[i] is the id in edges_of(body)[i].other.
//   3. One of a pair's copies holds the prediction for the two bodies' present segments.
//   4. The order within a list says nothing; no result may depend on it.
//   5. Rooms are a power of two times the first one. A stretch that its list has left is in the
//      chain of those with its room, so that the next list which needs as much takes it.
// Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/check.h"
#include "worker/physics/event/event.h"
#include "worker/physics/simulator/near_memory.h"

namespace sleight::physics {

/// What is predicted of a pair.
struct Prediction {
  Tick tick = k_never;        ///< nothing happens before
  std::uint32_t feature = 0;  ///< which of the pair's convex pieces meet, if they do
  bool certain = false;       ///< the collision is at `tick`; else the pair must be examined then
};

/// A pair has no search: its predictions are closed forms.
inline constexpr std::uint32_t k_no_search = UINT32_MAX;

/// Never a number of changes: a copy that has no prediction.
inline constexpr std::uint32_t k_void = UINT32_MAX;

/// Half a cache line.
struct alignas(32) PairEdge {
  Tick tick = k_never;  ///< of the prediction, as are `feature` and `certain`
  std::uint32_t feature = 0;
  std::uint32_t other = 0;
  std::uint32_t mirror = 0;
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
    std::size_t list = 16;     ///< edges of each list before it moves
    std::size_t average = 16;  ///< edges per body before anything is allocated
  };

  void reset(std::size_t bodies, const Room& room) {
    first_room_ = static_cast<std::uint32_t>(room.list);
    left_.fill(k_none);
    // Lists that move leave their stretches behind, which are at most as much as all that is in
    // use.
    edges_.reserve(bodies * std::max(room.list, 2 * room.average));
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

  PairEdge& mirror_of(const PairEdge& edge) {
    return edges_[lists_[edge.other].begin + std::size_t{edge.mirror}];
  }

  /// Adds a pair and returns a's copy, valid until the next change.
  PairEdge& add(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t place_a = lists_[a].count;
    const std::uint32_t place_b = lists_[b].count;
    append(b, a, place_a);
    return append(a, b, place_b);
  }

  /// a's copy of the pair's edge; null if there is none.
  PairEdge* find(std::uint32_t a, std::uint32_t b) {
    const std::span<const BodyId> others = others_of(a);
    for (std::size_t place = 0; place < others.size(); ++place) {
      if (others[place].value == b) return &edges_of(a)[place];
    }
    return nullptr;
  }

  /// Removes a pair; the last edges of the two lists take the places. REQUIRES: it is there.
  void remove(std::uint32_t a, std::uint32_t b) {
    const std::span<const BodyId> others = others_of(a);
    std::uint32_t place = 0;
    while (others[place].value != b)
      ++place;
    take_out(b, edges_of(a)[place].mirror);
    take_out(a, place);
  }

 private:
  static constexpr std::uint32_t k_none = UINT32_MAX;
  struct List {
    std::uint32_t begin = 0;  ///< in edges_ and others_
    std::uint32_t count = 0;
    std::uint32_t doublings = 0;  ///< of the first room
  };

  PairEdge& append(std::uint32_t body, std::uint32_t other, std::uint32_t mirror) {
    List& list = lists_[body];
    if (list.count == first_room_ << list.doublings) [[unlikely]] {
      move(list);
    }
    const std::size_t at = std::size_t{list.begin} + list.count++;
    others_[at] = {other};
    return edges_[at] = {.other = other, .mirror = mirror};
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

  void take_out(std::uint32_t body, std::uint32_t place) {
    List& list = lists_[body];
    const std::span<PairEdge> edges = edges_of(body);
    --list.count;
    if (place == list.count) return;
    edges[place] = edges.back();
    others_[std::size_t{list.begin} + place] = {edges[place].other};
    mirror_of(edges[place]).mirror = place;
  }

  std::uint32_t first_room_ = 1;
  std::vector<List> lists_;
  NearVector<PairEdge> edges_;
  NearVector<BodyId> others_;
  std::array<std::uint32_t, 32> left_{};  ///< by doublings: the first stretch that a list has left
};

}  // namespace sleight::physics
