// Grids of cells, one for each size of box: a move costs what lies near, however bodies cluster.
//
// Idea. Spatial hashing by levels (Mirtich 1996; the thesis names it in 3.4 as the way out where
// sorted lists degrade). A box belongs to the level of its longest edge, levels a factor of two
// apart, and to the one cell of that level which holds its low corner. A box that overlaps a query
// has its low corner between the query's low corner less the longest edge of that level, and the
// query's high corner; so a query walks those cells on each level that has boxes. Sizes mix freely:
// big boxes are not spread over many cells, small ones not crowded into few.
//
// Where the cells to walk would be more than the boxes of the level (a huge box among small ones),
// the query compares with all boxes of that level instead. Boxes beyond the highest level are
// compared with always.
//
// A move takes the ended overlaps from the sink's neighbours, and for begun ones queries with the
// new box and leaves out whom the old box overlapped. A new box within the old one begins nothing,
// so it needs no query.
//
// Invariants (beside those of broad_phase.h)
//   1. Each present body is listed once in members_ of its level, and linked in one cell unless its
//      level is the highest.
//   2. On each axis reach_[level] is at least the extent of every box of the level, in the units of
//      Axis; it only grows until the level is empty.
// Cells on an axis that repeats divide the period evenly, and are found from coded boxes, so that
// wrapping is exact.
// Thread safety: none.
#pragma once

#include <limits>

#include "worker/physics/broad_phase/body_boxes.h"
#include "worker/physics/broad_phase/brick_map.h"

namespace sleight::physics {

class HierarchicalGrid {
 public:
  explicit HierarchicalGrid(const BroadPhaseOptions& options);

  const Box& box(BodyId body) const { return boxes_.box(body.value); }
  bool contains(BodyId body) const { return boxes_.contains(body.value); }

  template <OverlapSink Sink>
  void insert(BodyId body, const Box& box, Sink& sink);
  template <OverlapSink Sink>
  void move(BodyId body, const Box& box, Sink& sink);
  template <OverlapSink Sink>
  void remove(BodyId body, Sink& sink);
  template <PairSink Sink>
  void move_all(std::span<const Box> boxes, Sink& sink);

 private:
  static constexpr std::uint32_t k_levels = 32;
  /// The level of boxes as long as options.size_m; those of 2^-12 to 2^18 times that have their
  /// own.
  static constexpr int k_level_typical = 12;
  static constexpr std::uint32_t k_level_unbounded = k_levels - 1;
  /// Bricks that a query may span on an axis before it gives up cells.
  static constexpr std::size_t k_span_max = 24;

  /// Bricks that a query touches on one axis, and for each the cells of a brick that count.
  struct Span {
    std::size_t count = 0;
    std::array<std::uint64_t, k_span_max> brick;
    std::array<std::uint64_t, k_span_max> cells;
    bool add(std::size_t axis, std::int64_t first, std::int64_t last);
  };
  /// How a level divides an axis. Extents and reach: metres, or ring points if it repeats.
  struct Axis {
    double cells_per_m = 0;   ///< of an axis that does not repeat
    std::uint64_t cells = 0;  ///< of a period
  };

  std::uint32_t level_of(const Box& box) const;
  CellAddress address_of(std::uint32_t level, const Box& box, const CodedBox& code) const;
  bool span_of(std::uint32_t level, std::size_t axis, const Box& box, const CodedBox& code,
               Span& span) const;
  /// Puts a body that is in no level into that of its box.
  void place(std::uint32_t body);
  /// Takes a body out of its level.
  void displace(std::uint32_t body);
  /// Replaces a present body's box.
  void change(std::uint32_t body, const Box& box, const CodedBox& code);
  void widen_reach(std::uint32_t level, const Box& box, const CodedBox& code);

  /// Writes to gathered_ the first bodies of all cells of the level that a body which overlaps this
  /// box may be in, and returns their end; null if it is better to look at all of the level.
  std::uint32_t* gather(std::uint32_t level, const Box& box, const CodedBox& code);
  /// Puts into begun_ the bodies for which test(body, its coded box) holds. REQUIRES: it holds only
  /// for bodies that overlap this box.
  template <class Test>
  void find_begun(const Box& box, const CodedBox& code, const Test& test);

  /// Bodies, each appended if something holds, without a branch that the processor could guess
  /// wrong.
  struct Chosen {
    std::vector<std::uint32_t> ids;
    std::size_t count = 0;
    void add_if(bool wanted, std::uint32_t body) {
      ids[count] = body;
      count += wanted ? 1 : 0;
    }
    std::span<const std::uint32_t> all() const { return {ids.data(), count}; }
  };

  BodyBoxes boxes_;
  double sizes_per_m_;
  std::array<std::array<Axis, 3>, k_levels> axes_{};
  std::array<std::array<double, 3>, k_levels> reach_{};
  std::uint32_t levels_used_ = 0;  ///< bit per level that has bodies
  std::array<std::vector<std::uint32_t>, k_levels> members_;
  std::vector<std::uint32_t> level_;      ///< by body
  std::vector<std::uint32_t> member_at_;  ///< by body: index in members_
  BrickMap bricks_;
  std::vector<CodedBox> before_;         ///< move_all: the boxes that it replaces
  std::vector<std::uint32_t> gathered_;  ///< candidates from cells
  Chosen begun_;                         ///< told once the structure is up to date
  Chosen ended_;
};

template <class Test>
void HierarchicalGrid::find_begun(const Box& box, const CodedBox& code, const Test& test) {
  begun_.count = 0;
  for (std::uint32_t left = levels_used_; left != 0; left &= left - 1) {
    const auto level = static_cast<std::uint32_t>(std::countr_zero(left));
    std::uint32_t* end = gather(level, box, code);
    if (end == nullptr) {
      for (const std::uint32_t other : members_[level])
        begun_.add_if(test(other, boxes_.coded(other)), other);
      continue;
    }
    // Test each, and append whoever comes next in its cell.
    for (std::uint32_t* at = gathered_.data(); at != end; ++at) {
      const std::uint32_t other = *at;
      const CodedBox& there = boxes_.coded(other);
      begun_.add_if(test(other, there), other);
      *end = BrickMap::next(there);
      end += *end != k_nobody ? 1 : 0;
    }
  }
}

template <OverlapSink Sink>
void HierarchicalGrid::insert(BodyId body, const Box& box, Sink& sink) {
  boxes_.check_absent(body);
  const CodedBox code = boxes_.periods().coded(box);
  find_begun(box, code, [&](std::uint32_t, const CodedBox& there) { return overlap(code, there); });
  boxes_.add(body.value);
  boxes_.set(body.value, box, code);
  place(body.value);
  for (const std::uint32_t other : begun_.all())
    sink.begin(BodyId{other});
}

template <OverlapSink Sink>
void HierarchicalGrid::move(BodyId body, const Box& box, Sink& sink) {
  boxes_.check_present(body);
  const CodedBox before = boxes_.coded(body.value);
  const CodedBox after = boxes_.periods().coded(box);

  // Neighbours that the new box does not overlap have ended.
  ended_.count = 0;
  const std::span<const BodyId> neighbours = sink.neighbours();
  for (const BodyId other : neighbours)
    ended_.add_if(!overlap(after, boxes_.coded(other.value)), other.value);
  // Whom the new box overlaps, and the old one did not, begins; the old one overlaps itself.
  begun_.count = 0;
  if (!holds(before, after)) {
    find_begun(box, after, [&](std::uint32_t, const CodedBox& there) {
      return overlap(after, there) & !overlap(before, there);
    });
  }
  change(body.value, box, after);
  for (const std::uint32_t other : ended_.all())
    sink.end(BodyId{other});
  for (const std::uint32_t other : begun_.all())
    sink.begin(BodyId{other});
}

template <OverlapSink Sink>
void HierarchicalGrid::remove(BodyId body, Sink& sink) {
  boxes_.check_present(body);
  displace(body.value);
  boxes_.take_away(body.value);
  ended_.count = 0;
  const std::span<const BodyId> neighbours = sink.neighbours();
  for (const BodyId other : neighbours)
    ended_.add_if(true, other.value);
  for (const std::uint32_t other : ended_.all())
    sink.end(BodyId{other});
}

template <PairSink Sink>
void HierarchicalGrid::move_all(std::span<const Box> boxes, Sink& sink) {
  CHECK_EQ(boxes.size(), std::size_t{boxes_.bodies()});
  before_.assign(boxes_.all_coded().begin(), boxes_.all_coded().end());
  for (std::uint32_t body = 0; body < boxes_.bodies(); ++body) {
    if (boxes_.contains(body)) change(body, boxes[body], boxes_.periods().coded(boxes[body]));
  }
  for (std::uint32_t body = 0; body < boxes_.bodies(); ++body) {
    if (!boxes_.contains(body)) continue;
    // Each pair is told by its lower body.
    const CodedBox after = boxes_.coded(body);
    const CodedBox before = before_[body];
    ended_.count = 0;
    const std::span<const BodyId> neighbours = sink.neighbours(BodyId{body});
    for (const BodyId other : neighbours) {
      ended_.add_if((other.value > body) & !overlap(after, boxes_.coded(other.value)), other.value);
    }
    find_begun(boxes[body], after, [&](std::uint32_t other, const CodedBox& there) {
      return (other > body) & overlap(after, there) & !overlap(before, before_[other]);
    });
    for (const std::uint32_t other : ended_.all())
      sink.end(BodyId{body}, BodyId{other});
    for (const std::uint32_t other : begun_.all())
      sink.begin(BodyId{body}, BodyId{other});
  }
}

static_assert(BroadPhase<HierarchicalGrid>);

}  // namespace sleight::physics
