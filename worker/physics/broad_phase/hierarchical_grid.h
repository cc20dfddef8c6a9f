// Grids of cells, one per size of box. The cost of a move depends only on nearby boxes, even in
// clusters.
//
// Idea. The method is spatial hashing by levels (Mirtich 1996). The thesis (3.4) names this method
// as the alternative where sorted lists degrade. A box's longest edge determines its level; levels
// are a factor of four apart. In its level, a box belongs to the cell that contains the box's low
// corner. Let w be the greatest width of a level's boxes. If a box overlaps a query, the box's low
// corner is between the query's low corner minus w and the query's high corner. So a query visits
// only the cells in this range. Big boxes are not spread over many cells, and small boxes are not
// crowded into few. All levels share one dense table (cell_table.h).
//
// If a query would visit more cells than the level has boxes, the query is compared with all these
// boxes instead. Boxes in the highest level have no maximum length and are always compared.
//
// A move finds the ended overlaps among the neighbours that the sink lists. To find begun overlaps,
// the move queries with the new box and ignores bodies that the old box overlapped. If the new box
// is inside the old box, the move makes no query.
//
// Each level rounds coordinates down to whole units. A unit is a small part of a cell:
//
//   - On a repeating axis, a unit is 2^shift ring points (periodic.h), and the period is divided
//     into equal cells.
//   - On a non-repeating axis, a unit is 2^-k_unit_bits of a cell.
//
// Rounding preserves order, so boxes that overlap also overlap in units. All other steps are exact.
//
// Invariants (in addition to broad_phase.h)
//   1. Each present body is listed once in `members` of its level. Unless this level is the
//      highest, the body is also linked in one cell.
//   2. On each axis, a level's `reach` is at least the width of each sketch in the level. If a
//      level has n boxes, `reach` is recomputed after about 4n changes.
// Thread safety: none.
#pragma once

#include <limits>
#include <optional>

#include "worker/physics/broad_phase/body_boxes.h"
#include "worker/physics/broad_phase/cell_table.h"

namespace sleight::physics {

class HierarchicalGrid {
 public:
  explicit HierarchicalGrid(const BroadPhaseOptions& options);

  const Box& box(BodyId body) const { return boxes_.box(body); }
  bool contains(BodyId body) const { return boxes_.contains(body); }
  void fetch(BodyId body) const { boxes_.fetch(body); }

  template <OverlapSink Sink>
  void insert(BodyId body, const Box& box, Sink& sink);
  template <OverlapSink Sink>
  void move(BodyId body, const Box& box, Sink& sink);
  template <OverlapSink Sink>
  void remove(BodyId body, Sink& sink);
  template <PairSink Sink>
  void move_all(std::span<const Box> boxes, Sink& sink);

 private:
  static constexpr std::uint32_t k_levels = 16;
  static constexpr int k_bits_per_level = 2;
  /// Level of a box whose longest edge is options.size_m. The bounded levels are for edges of 4^-6
  /// to 4^8 times options.size_m.
  static constexpr int k_level_typical = 6;
  static constexpr std::uint32_t k_level_unbounded = k_levels - 1;
  /// Maximum number of cells that a query may visit on an axis. A larger query is compared with all
  /// boxes instead.
  static constexpr std::uint32_t k_span_max = 32;
  /// Number of slots whose hits are judged together: 8 blocks of 8 slots.
  static constexpr std::size_t k_batch = 64;

  struct Axis {
    double units_per_m = 0;    ///< on a non-repeating axis
    int shift = 0;             ///< on a repeating axis: a unit is 2^shift ring points
    std::uint32_t cells = 0;   ///< per period
    std::uint32_t stride = 0;  ///< difference of the numbers of neighbouring cells on this axis
    std::uint32_t reach = 0;   ///< invariant 2; k_whole_ring if a sketch covers the ring
  };
  struct Level {
    std::array<Axis, 3> axes;
    std::uint32_t cell_zero = 0;  ///< number of the cell at the origin
    std::uint64_t changes = 0;    ///< since `reach` was computed
    std::vector<BodyId> members;
  };
  /// A box in a level's units. On a repeating axis the extent starts within the period.
  struct Extent {
    std::array<std::int64_t, 3> first;
    std::array<std::int64_t, 3> last;
    Sketch sketch() const;
  };
  /// A box's level and extent. In the highest level, boxes have no extents.
  struct Placement {
    std::uint32_t number = 0;  ///< number of the level
    Extent extent;
  };
  /// A cell's number is a sum of one part per axis. A Span contains one axis's parts, for all cells
  /// that a query visits.
  struct Span {
    std::uint32_t count = 0;
    std::array<std::uint32_t, k_span_max> part;
    bool add(std::uint32_t stride, std::int64_t first, std::int64_t last);
  };

  std::uint32_t level_of(const Box& box) const;
  void divide(Level& level, double edge_m, std::uint32_t number);
  bool periodic(std::size_t axis) const { return boxes_.periods().periodic(axis); }
  Extent extent_of(const Level& level, const Box& box, const CodedBox& code) const;
  std::uint32_t cell_of(const Level& level, const Extent& extent) const;
  bool span_of(const Level& level, std::size_t axis, const Extent& extent, Span& span) const;

  Placement placement_of(const Box& box, const CodedBox& code) const;
  /// REQUIRES: the body is in no level.
  void place(BodyId body, const Placement& at);
  void displace(BodyId body);
  void change(BodyId body, const Box& box, const CodedBox& code, const Placement& to);
  void widen_reach(Level& level, const Sketch& sketch);

  /// Finds the cells of this level that may contain bodies that overlap the box. Writes each cell's
  /// first block to near_. Returns the number of blocks, or nothing if comparing the whole level is
  /// cheaper.
  std::optional<std::size_t> cells_near(const Level& level, const Extent& extent);
  /// Fills begun_, without repetition. A body is stored if test(body, its coded box) returns true.
  /// REQUIRES: `test` returns true only for bodies that overlap this box.
  template <class Test>
  void find_begun(const Box& box, const CodedBox& code, const Placement& at, const Test& test);
  /// The part of find_begun() for the cells near_[0] to near_[cells - 1].
  template <class Test>
  void find_in_cells(std::size_t cells, const CellTable::Query& query, const Test& test);
  void begin_query();
  /// Drops bodies that the query has found before. Leaves the entries of begun_ below index `from`
  /// as they are.
  void drop_repeated(std::size_t from);

  /// A list of bodies. Appends conditionally without a branch, because a branch may be
  /// mispredicted.
  struct Chosen {
    std::vector<BodyId> ids;
    std::size_t count = 0;
    void add_if(bool wanted, BodyId body) {
      ids[count] = body;
      count += wanted ? 1 : 0;
    }
    std::span<const BodyId> all() const { return {ids.data(), count}; }
  };

  BodyBoxes boxes_;  ///< coded width[3]: the last query that found the body
  double sizes_per_m_;
  std::array<Level, k_levels> levels_{};
  std::uint32_t levels_used_ = 0;         ///< a bit per level that has bodies
  std::vector<std::uint8_t> level_;       ///< by body
  std::vector<std::uint32_t> member_at_;  ///< by body: index in members
  CellTable cells_;
  std::uint32_t query_ = 0;          ///< number of the last query
  std::vector<CodedBox> before_;     ///< move_all: the replaced boxes
  std::vector<std::uint32_t> near_;  ///< blocks
  Chosen begun_;                     ///< reported once the structure is up to date
  Chosen ended_;
};

template <class Test>
void HierarchicalGrid::find_in_cells(std::size_t cells, const CellTable::Query& query,
                                     const Test& test) {
  // Collect possible overlaps as bits, eight blocks at a time, and then loop over the bits. So the
  // processor mispredicts only the ends of a few loops.
  std::array<std::uint32_t, k_batch / CellTable::k_slots> blocks{};
  std::size_t count = 0;
  std::uint64_t bits = 0;
  std::size_t from = begun_.count;
  const auto judge = [&] {
    for (; bits != 0; bits &= bits - 1) {
      const auto bit = static_cast<std::uint32_t>(std::countr_zero(bits));
      const BodyId other{cells_.body(blocks[bit / CellTable::k_slots], bit % CellTable::k_slots)};
      begun_.add_if(test(other, boxes_.coded(other)), other);
    }
    count = 0;
    if (begun_.count + k_batch < begun_.ids.size()) return;
    drop_repeated(from);
    from = begun_.count;
  };
  for (std::size_t i = 0; i < cells; ++i) {
    for (std::uint32_t block = near_[i]; block != CellTable::k_none; block = cells_.next(block)) {
      blocks[count] = block;
      bits |= std::uint64_t{cells_.overlapping(block, query)} << (CellTable::k_slots * count);
      if (++count == blocks.size()) judge();
    }
  }
  judge();
  drop_repeated(from);
}

template <class Test>
void HierarchicalGrid::find_begun(const Box& box, const CodedBox& code, const Placement& at,
                                  const Test& test) {
  begin_query();
  for (std::uint32_t left = levels_used_; left != 0; left &= left - 1) {
    const auto number = static_cast<std::uint32_t>(std::countr_zero(left));
    const Level& level = levels_[number];
    if (number != k_level_unbounded) {
      const Extent extent = number == at.number ? at.extent : extent_of(level, box, code);
      if (const auto cells = cells_near(level, extent)) {
        find_in_cells(*cells, CellTable::Query(extent.sketch()), test);
        continue;
      }
    }
    const std::size_t from = begun_.count;
    for (const BodyId other : level.members)
      begun_.add_if(test(other, boxes_.coded(other)), other);
    drop_repeated(from);
  }
}

template <OverlapSink Sink>
void HierarchicalGrid::insert(BodyId body, const Box& box, Sink& sink) {
  boxes_.check_absent(body);
  const CodedBox code = boxes_.periods().coded(box);
  const Placement at = placement_of(box, code);
  find_begun(box, code, at, [&](BodyId, const CodedBox& there) { return overlap(code, there); });
  boxes_.add(body);
  boxes_.set(body, box, code);
  place(body, at);
  for (const BodyId other : begun_.all())
    sink.begin(other);
}

template <OverlapSink Sink>
void HierarchicalGrid::move(BodyId body, const Box& box, Sink& sink) {
  boxes_.check_present(body);
  const CodedBox before = boxes_.coded(body);
  const CodedBox after = boxes_.periods().coded(box);
  const Placement to = placement_of(box, after);

  // An overlap with a neighbour has ended if the new box doesn't overlap the neighbour.
  ended_.count = 0;
  const std::span<const BodyId> neighbours = sink.neighbours();
  for (const BodyId other : neighbours)
    ended_.add_if(!overlap(after, boxes_.coded(other)), other);
  // An overlap begins with each body that the new box overlaps and the old box did not. The body
  // itself is excluded, because its old box overlaps it.
  begun_.count = 0;
  if (!holds(before, after)) {
    find_begun(box, after, to, [&](BodyId, const CodedBox& there) {
      return overlap(after, there) & !overlap(before, there);
    });
  }
  change(body, box, after, to);
  for (const BodyId other : ended_.all())
    sink.end(other);
  for (const BodyId other : begun_.all())
    sink.begin(other);
}

template <OverlapSink Sink>
void HierarchicalGrid::remove(BodyId body, Sink& sink) {
  boxes_.check_present(body);
  displace(body);
  boxes_.take_away(body);
  ended_.count = 0;
  const std::span<const BodyId> neighbours = sink.neighbours();
  for (const BodyId other : neighbours)
    ended_.add_if(true, other);
  for (const BodyId other : ended_.all())
    sink.end(other);
}

template <PairSink Sink>
void HierarchicalGrid::move_all(std::span<const Box> boxes, Sink& sink) {
  CHECK_EQ(boxes.size(), std::size_t{boxes_.bodies()});
  before_.assign(boxes_.all_coded().begin(), boxes_.all_coded().end());
  for (BodyId body{}; body < boxes_.bodies(); ++body) {
    if (!boxes_.contains(body)) continue;
    const CodedBox code = boxes_.periods().coded(boxes[body]);
    change(body, boxes[body], code, placement_of(boxes[body], code));
  }
  for (BodyId body{}; body < boxes_.bodies(); ++body) {
    if (!boxes_.contains(body)) continue;
    // Report a pair only when `body` has the lower id.
    const CodedBox after = boxes_.coded(body);
    const CodedBox before = before_[body];
    ended_.count = 0;
    const std::span<const BodyId> neighbours = sink.neighbours(body);
    for (const BodyId other : neighbours) {
      ended_.add_if((other > body) & !overlap(after, boxes_.coded(other)), other);
    }
    const Placement at = placement_of(boxes[body], after);
    find_begun(boxes[body], after, at, [&](BodyId other, const CodedBox& there) {
      return (other > body) & overlap(after, there) & !overlap(before, before_[other]);
    });
    for (const BodyId other : ended_.all())
      sink.end(body, other);
    for (const BodyId other : begun_.all())
      sink.begin(body, other);
  }
}

static_assert(BroadPhase<HierarchicalGrid>);

}  // namespace sleight::physics
