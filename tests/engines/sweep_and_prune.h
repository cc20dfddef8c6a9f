// Sweep-and-prune as in the thesis (3.2.3, figures 3.3 and 3.5; after Cohen et al. 1995).
//
// Idea. Each axis has a sorted list of extents and a table of overlapping pairs. Another table
// lists the pairs that overlap in space. When a box changes, its extents travel through the lists.
// When a first point passes a last point, the axis's table changes. A pair that is in all three
// tables overlaps in space. An extent that moves little passes few other extents. But in a pile on
// a floor, a vertical extent passes nearly all other extents (3.3.2). In an evenly filled cube, an
// axis's table has about n^(5/3) pairs, and most of these pairs don't overlap in space.
//
// Invariants (in addition to broad_phase.h)
//   1. Axis table k holds exactly the pairs of present bodies whose arcs on axis k overlap.
//   2. The table of space holds the pairs that are in all three axis tables.
// Boxes, not passes, determine whether a pair overlaps on an axis, because arcs on a ring may pass
// each other at both ends. Insertion and removal examine all bodies. Thread safety: none.
#pragma once

#include <algorithm>

#include "tests/engines/extent_ring.h"
#include "worker/physics/broad_phase/body_boxes.h"
#include "worker/physics/broad_phase/flat_table.h"

namespace sleight::physics {

struct PairSlot {
  std::uint64_t key = k_no_key;
};
using PairTable = FlatTable<PairSlot>;

/// Returns the key of a pair of bodies. The bodies' order doesn't matter. REQUIRES: a != b.
constexpr std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) {
  return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
}

class SweepAndPrune {
 public:
  explicit SweepAndPrune(const BroadPhaseOptions& options)
      : boxes_(options),
        rings_{ExtentRing(options.bodies), ExtentRing(options.bodies), ExtentRing(options.bodies)},
        axis_pairs_{PairTable(room(options, k_axis_room)), PairTable(room(options, k_axis_room)),
                    PairTable(room(options, k_axis_room))},
        space_pairs_(room(options, k_space_room)) {
    touched_.reserve(4 * std::size_t{options.bodies});
    pairs_touched_.reserve(room(options, k_axis_room));
    before_.reserve(options.bodies);
  }

  const Box& box(BodyId body) const { return boxes_.box(body); }
  bool contains(BodyId body) const { return boxes_.contains(body); }

  template <OverlapSink Sink>
  void insert(BodyId body, const Box& box, Sink& sink);
  template <OverlapSink Sink>
  void move(BodyId body, const Box& box, Sink& sink);
  template <OverlapSink Sink>
  void remove(BodyId body, Sink& sink);
  template <PairSink Sink>
  void move_all(std::span<const Box> boxes, Sink& sink);

 private:
  /// Initial capacity of the tables, in pairs per body.
  static constexpr std::size_t k_axis_room = 64;
  static constexpr std::size_t k_space_room = 24;
  static std::size_t room(const BroadPhaseOptions& options, std::size_t per_body) {
    const std::size_t others = options.bodies == 0 ? 0 : options.bodies - 1;
    return options.bodies * std::min(others, per_body);
  }

  /// Updates an axis's table for a pair. Returns whether the table changed.
  bool look_again(std::size_t axis, BodyId a, BodyId b) {
    const std::uint64_t key = pair_key(a, b);
    return overlap(boxes_.coded(a).arc(axis), boxes_.coded(b).arc(axis))
               ? axis_pairs_[axis].insert(key).second
               : axis_pairs_[axis].erase(key);
  }
  bool in_all_axes(std::uint64_t key) const {
    return axis_pairs_[0].contains(key) && axis_pairs_[1].contains(key) &&
           axis_pairs_[2].contains(key);
  }
  /// Updates the table of space for a pair and reports a change.
  template <class Begin, class End>
  void settle(std::uint64_t key, const Begin& begin, const End& end) {
    if (in_all_axes(key)) {
      if (space_pairs_.insert(key).second) begin();
    } else {
      if (space_pairs_.erase(key)) end();
    }
  }

  BodyBoxes boxes_;
  std::array<ExtentRing, 3> rings_;
  std::array<PairTable, 3> axis_pairs_;
  PairTable space_pairs_;
  std::vector<CodedBox> before_;              ///< move_all: the replaced boxes
  std::vector<BodyId> touched_;               ///< move: bodies whose state on some axis changed
  std::vector<std::uint64_t> pairs_touched_;  ///< move_all: pairs whose state on some axis changed
};

template <OverlapSink Sink>
void SweepAndPrune::insert(BodyId body, const Box& box, Sink& sink) {
  boxes_.check_absent(body);
  boxes_.set(body, box, boxes_.periods().coded(box));
  for (BodyId other{}; other < boxes_.bodies(); ++other) {
    if (!boxes_.contains(other)) continue;
    bool changed = false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      changed |= look_again(axis, body, other);
    if (changed)
      settle(
          pair_key(body, other), [&] { sink.begin(other); }, [] {});
  }
  boxes_.add(body);
  for (std::size_t axis = 0; axis < 3; ++axis)
    rings_[axis].insert(body, boxes_.coded(body).arc(axis));
}

template <OverlapSink Sink>
void SweepAndPrune::remove(BodyId body, Sink& sink) {
  boxes_.check_present(body);
  boxes_.take_away(body);
  for (std::size_t axis = 0; axis < 3; ++axis)
    rings_[axis].remove(body);
  const CodedBox& gone = boxes_.coded(body);
  for (BodyId other{}; other < boxes_.bodies(); ++other) {
    if (!boxes_.contains(other)) continue;
    const std::uint64_t key = pair_key(body, other);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (overlap(gone.arc(axis), boxes_.coded(other).arc(axis))) axis_pairs_[axis].erase(key);
    }
    if (overlap(gone, boxes_.coded(other)) && space_pairs_.erase(key)) sink.end(other);
  }
}

template <OverlapSink Sink>
void SweepAndPrune::move(BodyId body, const Box& box, Sink& sink) {
  boxes_.check_present(body);
  const CodedBox before = boxes_.coded(body);
  boxes_.set(body, box, boxes_.periods().coded(box));
  const CodedBox& after = boxes_.coded(body);

  // Move the extents on each axis. Note each body whose overlap with the moved body changed on the
  // axis.
  touched_.clear();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const ArcTravel by = travel(before.arc(axis), after.arc(axis), boxes_.periods().periodic(axis));
    rings_[axis].move(body, by, [&](std::uint32_t met) {
      const BodyId other{met};
      if (look_again(axis, body, other)) touched_.push_back(other);
    });
  }
  // Derive the changes in space.
  for (const BodyId other : touched_) {
    settle(
        pair_key(body, other), [&] { sink.begin(other); }, [&] { sink.end(other); });
  }
}

template <PairSink Sink>
void SweepAndPrune::move_all(std::span<const Box> boxes, Sink& sink) {
  CHECK_EQ(boxes.size(), std::size_t{boxes_.bodies()});
  before_.assign(boxes_.all_coded().begin(), boxes_.all_coded().end());
  for (BodyId body{}; body < boxes_.bodies(); ++body) {
    if (boxes_.contains(body)) boxes_.set(body, boxes[body], boxes_.periods().coded(boxes[body]));
  }

  // Sort each axis's list again. Note the pairs whose overlap on the axis changed.
  pairs_touched_.clear();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool periodic = boxes_.periods().periodic(axis);
    const auto travel_of = [&](std::uint32_t index) {
      const BodyId body{index};
      return travel(before_[body].arc(axis), boxes_.coded(body).arc(axis), periodic);
    };
    rings_[axis].move_all(travel_of, [&](std::uint32_t a, std::uint32_t b) {
      if (look_again(axis, {a}, {b})) pairs_touched_.push_back(pair_key(a, b));
    });
  }
  // Derive the changes in space.
  for (const std::uint64_t key : pairs_touched_) {
    const BodyId lower{static_cast<std::uint32_t>(key >> 32)};
    const BodyId higher{static_cast<std::uint32_t>(key)};
    settle(
        key, [&] { sink.begin(lower, higher); }, [&] { sink.end(lower, higher); });
  }
}

static_assert(BroadPhase<SweepAndPrune>);

}  // namespace sleight::physics
