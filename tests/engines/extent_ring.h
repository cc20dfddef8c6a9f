// One axis of sweep-and-prune. The axis is a ring, and each body covers an arc of it. The ring
// stores the ends of all arcs in order.
//
// Idea. A list of extents sorted along an axis (thesis 3.2.3) becomes a circle, so a repeating axis
// needs no copies of boxes near its ends. When an arc changes, its two ends travel through the
// circle past their neighbours. Two arcs begin or cease to overlap only when the first point of one
// arc passes the last point of the other arc. Only these passes name pairs to check (thesis, figure
// 3.5).
//
// An end is a number with three fields: its place on the ring (32 bits), whether it is the first or
// last point (1 bit), and its body (28 bits). First points precede last points at the same place,
// because boxes are closed. All ends are different, so their order has no ties.
//
// Invariants
//   1. From any entry on, the list's entries are in order of forward distance around the circle.
//      The circle's length is 2^61.
//   2. place(body, kind) is the index of the body's end in the list.
// On a non-repeating axis, no travel crosses the seam between the greatest and the least float. So
// the list of such an axis is a rotation of a sorted list. Thread safety: none.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/broad_phase/periodic.h"

namespace sleight::physics {

/// Signed travels of an arc's two ends. A travel is less than one turn.
struct ArcTravel {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// Returns how an arc's ends travel to another arc. The arc never turns inside out. On a repeating
/// axis, the arc travels the shorter way. On another axis, the arc stays within the axis.
constexpr ArcTravel travel(Arc from, Arc to, bool periodic) {
  constexpr std::int64_t k_turn = std::int64_t{1} << 32;
  const std::int64_t wider = std::int64_t{to.width} - std::int64_t{from.width};
  std::int64_t first = std::int64_t{to.start} - std::int64_t{from.start};
  if (periodic) {
    first = static_cast<std::int32_t>(to.start - from.start);
    // If an arc grows to nearly the whole ring, its last point must not lap its first point.
    if (first + wider >= k_turn) first -= k_turn;
    if (first + wider <= -k_turn) first += k_turn;
  }
  return {first, first + wider};
}

class ExtentRing {
 public:
  /// REQUIRES: bodies <= k_bodies_max (28 bits).
  explicit ExtentRing(std::uint32_t bodies) : place_(std::size_t{bodies} * 2) {
    ends_.reserve(place_.size());
    lifted_.reserve(place_.size());
  }

  /// REQUIRES: the body is absent.
  void insert(std::uint32_t body, Arc arc);
  /// REQUIRES: the body is present.
  void remove(std::uint32_t body);

  /// Moves the body's ends. If an end passes an opposite end of another body, calls visit(other),
  /// at most twice per other body. REQUIRES: the body is present.
  template <class Visit>
  void move(std::uint32_t body, ArcTravel by, const Visit& visit) {
    move_end(body, k_first, by.first, visit);
    move_end(body, k_last, by.last, visit);
  }

  /// Moves the ends of all present bodies at once, by insertion sort. Calls visit(a, b) when
  /// opposite ends of bodies a and b pass each other. `travel_of(body)` returns a body's ArcTravel.
  template <class TravelOf, class Visit>
  void move_all(const TravelOf& travel_of, const Visit& visit);

 private:
  static constexpr std::uint64_t k_first = 0;
  static constexpr std::uint64_t k_last = std::uint64_t{1} << 28;
  static constexpr int k_place_shift = 29;
  static constexpr std::uint64_t k_turn = std::uint64_t{1} << 61;

  static std::uint32_t body_of(std::uint64_t end) {
    return static_cast<std::uint32_t>(end & (k_last - 1));
  }
  static std::uint64_t ahead(std::uint64_t from, std::uint64_t to) {
    return (to - from) & (k_turn - 1);
  }
  static std::uint64_t end_at(std::uint32_t point, std::uint64_t kind, std::uint32_t body) {
    return std::uint64_t{point} << k_place_shift | kind | body;
  }
  std::uint32_t& place(std::uint64_t end) {
    return place_[std::size_t{body_of(end)} * 2 + ((end & k_last) != 0 ? 1 : 0)];
  }
  void insert_end(std::uint64_t end);

  template <class Visit>
  void move_end(std::uint32_t body, std::uint64_t kind, std::int64_t by, const Visit& visit);

  /// Returns whether one end is a body's first point and the other end is another body's last
  /// point.
  static bool telling(std::uint64_t a, std::uint64_t b) {
    return ((a ^ b) & k_last) != 0 && body_of(a) != body_of(b);
  }
  static bool telling(std::int64_t a, std::int64_t b) {
    return telling(static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(b));
  }
  static std::uint32_t body_of(std::int64_t end) {
    return body_of(static_cast<std::uint64_t>(end));
  }
  template <class Visit>
  void sift_down(std::size_t from, const Visit& visit);
  template <class Visit>
  void sift_up(std::size_t from, const Visit& visit);

  std::vector<std::uint64_t> ends_;
  std::vector<std::uint32_t> place_;  ///< by body * 2 + (0 first, 1 last)
  std::vector<std::int64_t> lifted_;  ///< move_all: the ends on a line, not wrapped
};

template <class Visit>
void ExtentRing::move_end(std::uint32_t body, std::uint64_t kind, std::int64_t by,
                          const Visit& visit) {
  if (by == 0) return;
  const std::size_t count = ends_.size();
  std::size_t at = place(kind | body);
  const std::uint64_t from = ends_[at];
  const bool forwards = by > 0;
  const std::uint64_t distance = static_cast<std::uint64_t>(forwards ? by : -by) << k_place_shift;
  // Pass all ends within the distance, but at most one turn of ends (`passed`).
  for (std::size_t passed = 1; passed < count; ++passed) {
    const std::size_t neighbour =
        forwards ? (at + 1 == count ? 0 : at + 1) : (at == 0 ? count - 1 : at - 1);
    const std::uint64_t other = ends_[neighbour];
    if ((forwards ? ahead(from, other) : ahead(other, from)) >= distance) break;
    ends_[at] = other;
    place(other) = static_cast<std::uint32_t>(at);
    if (telling(from, other)) visit(body_of(other));
    at = neighbour;
  }
  ends_[at] = (forwards ? from + distance : from - distance) & (k_turn - 1);
  place(kind | body) = static_cast<std::uint32_t>(at);
}

template <class Visit>
void ExtentRing::sift_down(std::size_t from, const Visit& visit) {
  const std::int64_t end = lifted_[from];
  std::size_t at = from;
  for (; at > 0 && lifted_[at - 1] > end; --at) {
    if (telling(end, lifted_[at - 1])) visit(body_of(end), body_of(lifted_[at - 1]));
    lifted_[at] = lifted_[at - 1];
  }
  lifted_[at] = end;
}

template <class Visit>
void ExtentRing::sift_up(std::size_t from, const Visit& visit) {
  const std::int64_t end = lifted_[from];
  std::size_t at = from;
  for (; at + 1 < lifted_.size() && lifted_[at + 1] < end; ++at) {
    if (telling(end, lifted_[at + 1])) visit(body_of(end), body_of(lifted_[at + 1]));
    lifted_[at] = lifted_[at + 1];
  }
  lifted_[at] = end;
}

template <class TravelOf, class Visit>
void ExtentRing::move_all(const TravelOf& travel_of, const Visit& visit) {
  if (ends_.empty()) return;
  // Cut the circle before its first entry, lay it out as a line, and move all ends. Values on the
  // line stay between -1 and 3 turns, so they fit into 64 bits.
  lifted_.clear();
  for (const std::uint64_t end : ends_) {
    const ArcTravel by = travel_of(body_of(end));
    const std::int64_t way = (end & k_last) != 0 ? by.last : by.first;
    lifted_.push_back(static_cast<std::int64_t>(ends_[0] + ahead(ends_[0], end)) +
                      way * (std::int64_t{1} << k_place_shift));
  }
  // Sort the line.
  for (std::size_t i = 1; i < lifted_.size(); ++i)
    sift_down(i, visit);
  // Close the circle: while the last end is more than a turn ahead of the first end, let it pass
  // the first end.
  constexpr auto k_line_turn = static_cast<std::int64_t>(k_turn);
  while (lifted_.back() - lifted_.front() > k_line_turn) {
    const std::int64_t last = lifted_.back();
    const std::int64_t first = lifted_.front();
    if (telling(first, last)) visit(body_of(first), body_of(last));
    lifted_.front() = last - k_line_turn;
    lifted_.back() = first + k_line_turn;
    sift_up(0, visit);
    sift_down(lifted_.size() - 1, visit);
  }
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    ends_[i] = static_cast<std::uint64_t>(lifted_[i]) & (k_turn - 1);
    place(ends_[i]) = static_cast<std::uint32_t>(i);
  }
}

}  // namespace sleight::physics
