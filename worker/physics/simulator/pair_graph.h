// Which pairs of bodies are watched, and when each may collide next.
//
// Each body has a flat list of edges, one for each body whose bounding volume overlaps its own. The
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
// Thread safety: none.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/event/event.h"

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

struct PairEdge {
  Prediction prediction{};
  std::uint32_t other = 0;
  std::uint32_t mirror = 0;
  std::uint32_t other_changes = k_void;  ///< the other body's, when this was predicted
  std::uint32_t search = k_no_search;    ///< the same in both copies
};

class PairGraph {
 public:
  /// Lists of so many bodies, each with room for `room` edges before anything is allocated.
  void reset(std::size_t bodies, std::size_t room) {
    lists_.assign(bodies, {});
    for (List& list : lists_) {
      list.edges.reserve(room);
      list.others.reserve(room);
    }
  }

  std::span<PairEdge> edges_of(std::uint32_t body) { return lists_[body].edges; }
  std::span<const BodyId> others_of(std::uint32_t body) const { return lists_[body].others; }

  PairEdge& mirror_of(const PairEdge& edge) { return lists_[edge.other].edges[edge.mirror]; }

  /// Adds a pair and returns a's copy, valid until the next change.
  PairEdge& add(std::uint32_t a, std::uint32_t b) {
    List& of_a = lists_[a];
    List& of_b = lists_[b];
    const auto place_a = static_cast<std::uint32_t>(of_a.edges.size());
    const auto place_b = static_cast<std::uint32_t>(of_b.edges.size());
    of_b.edges.push_back({.other = a, .mirror = place_a});
    of_b.others.push_back({a});
    of_a.others.push_back({b});
    of_a.edges.push_back({.other = b, .mirror = place_b});
    return of_a.edges.back();
  }

  /// a's copy of the pair's edge; null if there is none.
  PairEdge* find(std::uint32_t a, std::uint32_t b) {
    List& list = lists_[a];
    for (std::size_t place = 0; place < list.others.size(); ++place) {
      if (list.others[place].value == b) return &list.edges[place];
    }
    return nullptr;
  }

  /// Removes a pair; the last edges of the two lists take the places. REQUIRES: it is there.
  void remove(std::uint32_t a, std::uint32_t b) {
    std::uint32_t place = 0;
    while (lists_[a].others[place].value != b)
      ++place;
    take_out(b, lists_[a].edges[place].mirror);
    take_out(a, place);
  }

 private:
  struct List {
    std::vector<PairEdge> edges;
    std::vector<BodyId> others;
  };

  void take_out(std::uint32_t body, std::uint32_t place) {
    List& list = lists_[body];
    if (place + 1 != list.edges.size()) {
      list.edges[place] = list.edges.back();
      list.others[place] = list.others.back();
      lists_[list.edges[place].other].edges[list.edges[place].mirror].mirror = place;
    }
    list.edges.pop_back();
    list.others.pop_back();
  }

  std::vector<List> lists_;
};

}  // namespace sleight::physics
