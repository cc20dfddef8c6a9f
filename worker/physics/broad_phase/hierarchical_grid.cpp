#include "worker/physics/broad_phase/hierarchical_grid.h"

#include <cmath>

namespace sleight::physics {
namespace {

/// k_longest is the longest box edge of the typical level, divided by the typical box size. k_cell
/// is a cell's edge, divided by the longest box edge of its level. Both values were measured in
/// gases of hard spheres at packings 0.1 and 0.4. The longest boxes of these gases are just below
/// the typical level's longest edge. Halving or doubling either value costs 5 to 30% of a
/// simulation's time.
constexpr double k_longest = 2.1;
constexpr double k_cell = 1.0;

/// Minimum units per cell. With u units per cell, a query finds about 1 + 3 / u times as many boxes
/// as necessary. A sketch's ring has 2^8 units, and boxes should be much shorter than the ring.
constexpr int k_unit_bits = 4;
constexpr int k_sketch_bits = 8;

/// Maximum number of cells per period. The limit keeps products with this number in 64 bits.
constexpr double k_cells_max = 0x1p16;
/// Coordinates beyond this many units are clamped.
constexpr double k_unit_limit = 0x1p40;

/// Difference between the numbers of neighbouring cells, for each axis. Used only if the grid has
/// more cells than the table. Cells near each other should not share a number. These values were
/// found by a search. For table sizes from 2^6 to 2^20, the shortest distance between two cells
/// with the same number is nearly as long as possible.
constexpr std::array<std::uint32_t, 3> k_strides = {1, 0x25CEA933U, 0xDA92657BU};
/// Difference between the cell_zero of successive levels.
constexpr std::uint32_t k_level_stride = 0xC2B2AE3DU;

/// Computes floor(place), clamped to k_unit_limit. On plain x86-64, std::floor would call libm.
std::int64_t unit_at(double place) {
  if (place >= k_unit_limit) return static_cast<std::int64_t>(k_unit_limit);
  if (place <= -k_unit_limit) return -static_cast<std::int64_t>(k_unit_limit);
  const auto whole = static_cast<std::int64_t>(place);
  return whole - (static_cast<double>(whole) > place ? 1 : 0);
}

/// Returns the length of the box's edge. If the length is NaN, returns infinity.
double edge_m(const Box& box, std::size_t axis) {
  const double edge = double{box.high_m[axis]} - double{box.low_m[axis]};
  return edge >= 0 ? edge : std::numeric_limits<double>::infinity();
}

}  // namespace

HierarchicalGrid::HierarchicalGrid(const BroadPhaseOptions& options)
    : boxes_(options),
      sizes_per_m_(1 / (options.size_m * k_longest)),
      level_(options.bodies),
      member_at_(options.bodies),
      cells_(options.bodies),
      near_(std::size_t{options.bodies} + 1) {
  begun_.ids.resize(2 * std::size_t{options.bodies} + 2 * k_batch);
  ended_.ids.resize(std::size_t{options.bodies} + 1);
  for (Level& level : levels_)
    level.members.reserve(options.bodies);
  for (std::uint32_t level = 0; level < k_level_unbounded; ++level) {
    const int power = k_bits_per_level * (static_cast<int>(level) - k_level_typical);
    divide(levels_[level], std::ldexp(options.size_m * k_longest, power), level);
  }
}

/// Sets a level's cells. The level's boxes are up to `edge_m` long.
void HierarchicalGrid::divide(Level& level, double edge_m, std::uint32_t number) {
  const double cell_m = k_cell * edge_m;
  double cells = 1;
  bool dense = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Axis& divided = level.axes[axis];
    divided.units_per_m = (1 << k_unit_bits) / cell_m;
    divided.stride = k_strides[axis];
    if (!periodic(axis)) {
      dense = false;
      continue;
    }
    const double fit = std::clamp(boxes_.periods().length_m(axis) / cell_m, 1.0, k_cells_max);
    divided.cells = static_cast<std::uint32_t>(fit);
    cells *= divided.cells;
    // A cell has at least 2^k_unit_bits units. The number of units per period is a power of two and
    // at least 2^k_sketch_bits. So the period is a whole number of a sketch's rings.
    const int more = static_cast<int>(std::bit_width(divided.cells)) + k_unit_bits - k_sketch_bits;
    divided.shift = 32 - k_sketch_bits - std::max(more, 0);
  }
  level.cell_zero = number * k_level_stride;
  if (!dense || cells > cells_.cells()) return;
  // The table has room for all cells, so each cell gets its own number.
  level.axes[1].stride = level.axes[0].cells;
  level.axes[2].stride = level.axes[0].cells * level.axes[1].cells;
}

std::uint32_t HierarchicalGrid::level_of(const Box& box) const {
  const double sizes = std::max({edge_m(box, 0), edge_m(box, 1), edge_m(box, 2)}) * sizes_per_m_;
  // Compute log2, rounded up, from the bits: the exponent, plus one if any fraction bit is set.
  const auto bits = std::bit_cast<std::uint64_t>(sizes);
  const int exponent = static_cast<int>(bits >> 52) - 1023;
  const bool more = (bits & ((std::uint64_t{1} << 52) - 1)) != 0;
  const int powers = exponent + (more ? 1 : 0) + k_bits_per_level * k_level_typical;
  const int level = (std::max(powers, 0) + k_bits_per_level - 1) / k_bits_per_level;
  return std::min(static_cast<std::uint32_t>(level), k_level_unbounded);
}

Sketch HierarchicalGrid::Extent::sketch() const {
  Sketch made;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    made.start[axis] = static_cast<RingPoint>(first[axis]);
    made.width[axis] =
        static_cast<RingPoint>(std::min<std::int64_t>(last[axis] - first[axis], k_whole_ring));
  }
  return made;
}

HierarchicalGrid::Extent HierarchicalGrid::extent_of(const Level& level, const Box& box,
                                                     const CodedBox& code) const {
  Extent made;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Axis& divided = level.axes[axis];
    if (periodic(axis)) {
      made.first[axis] = std::int64_t{code.start[axis]} >> divided.shift;
      made.last[axis] =
          (std::int64_t{code.start[axis]} + std::int64_t{code.width[axis]}) >> divided.shift;
    } else {
      made.first[axis] = unit_at(double{box.low_m[axis]} * divided.units_per_m);
      made.last[axis] = unit_at(double{box.high_m[axis]} * divided.units_per_m);
    }
  }
  return made;
}

std::uint32_t HierarchicalGrid::cell_of(const Level& level, const Extent& extent) const {
  std::uint32_t number = level.cell_zero;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Axis& divided = level.axes[axis];
    const std::int64_t cell = periodic(axis)
                                  ? extent.first[axis] * divided.cells >> (32 - divided.shift)
                                  : extent.first[axis] >> k_unit_bits;
    number += static_cast<std::uint32_t>(cell) * divided.stride;
  }
  return number;
}

bool HierarchicalGrid::Span::add(std::uint32_t stride, std::int64_t first, std::int64_t last) {
  if (last - first >= static_cast<std::int64_t>(k_span_max - count)) return false;
  std::uint32_t next = static_cast<std::uint32_t>(first) * stride;
  for (std::int64_t at = first; at <= last; ++at, next += stride)
    part[count++] = next;
  return true;
}

// Finds one axis's cells near the query. A box that overlaps the query has its low corner in one of
// these cells.
bool HierarchicalGrid::span_of(const Level& level, std::size_t axis, const Extent& extent,
                               Span& span) const {
  const Axis& divided = level.axes[axis];
  const std::int64_t low = extent.first[axis] - divided.reach;
  const std::int64_t high = extent.last[axis];
  if (!periodic(axis)) {
    return divided.reach != k_whole_ring &&
           span.add(divided.stride, low >> k_unit_bits, high >> k_unit_bits);
  }
  // Compute the first and last cell as if the axis didn't repeat. Then wrap this range into the
  // period: it becomes one range or two.
  const std::int64_t cells = divided.cells;
  const int period_bits = 32 - divided.shift;
  const std::int64_t first = low * cells >> period_bits;
  const std::int64_t last = high * cells >> period_bits;
  if (last - first + 1 >= cells || divided.reach == k_whole_ring)
    return span.add(divided.stride, 0, cells - 1);
  const std::int64_t from = first < 0 ? first + cells : first;
  const std::int64_t to = last >= cells ? last - cells : last;
  if (from <= to) return span.add(divided.stride, from, to);
  return span.add(divided.stride, from, cells - 1) && span.add(divided.stride, 0, to);
}

std::optional<std::size_t> HierarchicalGrid::cells_near(const Level& level, const Extent& extent) {
  std::array<Span, 3> spans;
  std::size_t cells = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!span_of(level, axis, extent, spans[axis])) return std::nullopt;
    cells *= spans[axis].count;
  }
  if (cells > level.members.size()) return std::nullopt;
  std::uint32_t* end = near_.data();
  for (std::size_t z = 0; z < spans[2].count; ++z) {
    for (std::size_t y = 0; y < spans[1].count; ++y) {
      const std::uint32_t row = level.cell_zero + spans[2].part[z] + spans[1].part[y];
      for (std::size_t x = 0; x < spans[0].count; ++x)
        end = cells_.add_if_any(row + spans[0].part[x], end);
    }
  }
  return static_cast<std::size_t>(end - near_.data());
}

void HierarchicalGrid::begin_query() {
  begun_.count = 0;
  if (++query_ != 0) return;
  // After 2^32 queries, query numbers start again at 1.
  for (BodyId body{}; body < boxes_.bodies(); ++body)
    boxes_.coded(body).width[3] = 0;
  query_ = 1;
}

void HierarchicalGrid::drop_repeated(std::size_t from) {
  std::size_t kept = from;
  for (std::size_t i = from; i < begun_.count; ++i) {
    const BodyId body = begun_.ids[i];
    std::uint32_t& found = boxes_.coded(body).width[3];
    begun_.ids[kept] = body;
    kept += found != query_ ? 1 : 0;
    found = query_;
  }
  begun_.count = kept;
}

void HierarchicalGrid::widen_reach(Level& level, const Sketch& sketch) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    level.axes[axis].reach = std::max<std::uint32_t>(level.axes[axis].reach, sketch.width[axis]);
  }
  if (++level.changes <= 4 * level.members.size()) return;
  level.changes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::uint32_t reach = 0;
    for (const BodyId body : level.members)
      reach = std::max<std::uint32_t>(reach, cells_.width(body, axis));
    level.axes[axis].reach = reach;
  }
}

HierarchicalGrid::Placement HierarchicalGrid::placement_of(const Box& box,
                                                           const CodedBox& code) const {
  Placement made;
  made.number = level_of(box);
  if (made.number != k_level_unbounded) made.extent = extent_of(levels_[made.number], box, code);
  return made;
}

void HierarchicalGrid::place(BodyId body, const Placement& at) {
  Level& level = levels_[at.number];
  level_[body] = static_cast<std::uint8_t>(at.number);
  member_at_[body] = static_cast<std::uint32_t>(level.members.size());
  level.members.push_back(body);
  levels_used_ |= std::uint32_t{1} << at.number;
  if (at.number == k_level_unbounded) return;
  const Sketch sketch = at.extent.sketch();
  cells_.link(body, cell_of(level, at.extent), sketch);
  widen_reach(level, sketch);
}

void HierarchicalGrid::displace(BodyId body) {
  const std::uint32_t number = level_[body];
  Level& level = levels_[number];
  level.members[member_at_[body]] = level.members.back();
  member_at_[level.members.back()] = member_at_[body];
  level.members.pop_back();
  if (number != k_level_unbounded) cells_.unlink(body);
  if (!level.members.empty()) return;
  levels_used_ &= ~(std::uint32_t{1} << number);
  level.changes = 0;
  for (Axis& axis : level.axes)
    axis.reach = 0;
}

void HierarchicalGrid::change(BodyId body, const Box& box, const CodedBox& code,
                              const Placement& to) {
  boxes_.set(body, box, code);
  if (to.number != level_[body]) {
    displace(body);
    place(body, to);
    return;
  }
  if (to.number == k_level_unbounded) return;
  Level& level = levels_[to.number];
  const Sketch sketch = to.extent.sketch();
  cells_.change(body, cell_of(level, to.extent), sketch);
  widen_reach(level, sketch);
}

}  // namespace sleight::physics
