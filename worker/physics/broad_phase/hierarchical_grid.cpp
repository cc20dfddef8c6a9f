#include "worker/physics/broad_phase/hierarchical_grid.h"

#include <cmath>

namespace sleight::physics {
namespace {

/// Cells per longest edge of a level's boxes. More of them fit closer around a query but cost more
/// steps; measured on hard spheres at packing 0.4, 2 is best.
constexpr double k_cells_per_edge = 2;

/// Boxes of just the typical size, rounded outwards, stay on its level.
constexpr double k_slack = 1 + 0x1p-6;

/// Cells beyond this are one, so that indices are exact in a double with room for the guard.
constexpr double k_cell_limit = 0x1p36;
/// Subtracting the reach from a low corner, and scaling it, rounds by less than this many cells.
constexpr double k_guard = 0x1p-12;

/// Floor, without libm's call on plain x86-64; saturates.
std::int64_t cell_at(double place) {
  if (place >= k_cell_limit) return static_cast<std::int64_t>(k_cell_limit);
  if (place <= -k_cell_limit) return -static_cast<std::int64_t>(k_cell_limit);
  const auto whole = static_cast<std::int64_t>(place);
  return static_cast<double>(whole) > place ? whole - 1 : whole;
}

/// By axis and by four bits, one per layer of a brick along the axis: the cells of these layers.
constexpr std::array<std::array<std::uint64_t, 16>, 3> k_layers = [] {
  std::array<std::array<std::uint64_t, 16>, 3> made{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t bits = 0; bits < 16; ++bits) {
      for (std::size_t cell = 0; cell < 64; ++cell) {
        const std::size_t layer = cell >> (2 * axis) & 3;
        if ((bits >> layer & 1) != 0) made[axis][bits] |= std::uint64_t{1} << cell;
      }
    }
  }
  return made;
}();

/// The edge in metres; infinite rather than NaN.
double edge_m(const Box& box, std::size_t axis) {
  const double edge = double{box.high_m[axis]} - double{box.low_m[axis]};
  return edge >= 0 ? edge : std::numeric_limits<double>::infinity();
}

}  // namespace

HierarchicalGrid::HierarchicalGrid(const BroadPhaseOptions& options)
    : boxes_(options),
      sizes_per_m_(1 / (options.size_m * k_slack)),
      level_(options.bodies),
      member_at_(options.bodies),
      bricks_(options.bodies),
      gathered_(options.bodies + std::size_t{BrickMap::k_overrun}) {
  begun_.ids.resize(options.bodies + 1);
  ended_.ids.resize(options.bodies + 1);
  double edge = std::ldexp(options.size_m * k_slack, -k_level_typical);
  for (std::uint32_t level = 0; level < k_level_unbounded; ++level, edge *= 2) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      axes_[level][axis].cells_per_m = k_cells_per_edge / edge;
      // Beyond 2^20 cells, indices of the same period would alias.
      const double cells = boxes_.periods().length_m(axis) * axes_[level][axis].cells_per_m;
      axes_[level][axis].cells = static_cast<std::uint64_t>(std::clamp(cells, 1.0, 0x1p20));
    }
  }
}

std::uint32_t HierarchicalGrid::level_of(const Box& box) const {
  const double sizes = std::max({edge_m(box, 0), edge_m(box, 1), edge_m(box, 2)}) * sizes_per_m_;
  // The logarithm to base 2, rounded up, is in the bits: exponent, and whether more follows.
  const auto bits = std::bit_cast<std::uint64_t>(sizes);
  const int exponent = static_cast<int>(bits >> 52) - 1023;
  const bool more = (bits & ((std::uint64_t{1} << 52) - 1)) != 0;
  const int level = exponent + (more ? 1 : 0) + k_level_typical;
  return static_cast<std::uint32_t>(std::clamp(level, 0, static_cast<int>(k_level_unbounded)));
}

CellAddress HierarchicalGrid::address_of(std::uint32_t level, const Box& box,
                                         const CodedBox& code) const {
  std::array<std::int64_t, 3> cell{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Axis& divided = axes_[level][axis];
    cell[axis] = boxes_.periods().periodic(axis)
                     ? static_cast<std::int64_t>(code.start[axis] * divided.cells >> 32)
                     : cell_at(double{box.low_m[axis]} * divided.cells_per_m);
  }
  return cell_address(level, cell[0], cell[1], cell[2]);
}

bool HierarchicalGrid::Span::add(std::size_t axis, std::int64_t first, std::int64_t last) {
  const std::int64_t first_brick = first >> 2;
  const std::int64_t last_brick = last >> 2;
  if (last_brick - first_brick >= static_cast<std::int64_t>(k_span_max - count)) return false;
  for (std::int64_t at = first_brick; at <= last_brick; ++at) {
    std::uint64_t layers = 15;
    if (at == first_brick) layers &= 15U << (first & 3);
    if (at == last_brick) layers &= 15U >> (3 - (last & 3));
    brick[count] = static_cast<std::uint64_t>(at);
    cells[count] = k_layers[axis][layers];
    ++count;
  }
  return true;
}

// The cells, on an axis, that low corners of a level's boxes may be in if they overlap the query.
bool HierarchicalGrid::span_of(std::uint32_t level, std::size_t axis, const Box& box,
                               const CodedBox& code, Span& span) const {
  const Axis& divided = axes_[level][axis];
  const double reach = reach_[level][axis];
  if (!boxes_.periods().periodic(axis)) {
    const double low = (double{box.low_m[axis]} - reach) * divided.cells_per_m - k_guard;
    const double high = double{box.high_m[axis]} * divided.cells_per_m;
    return span.add(axis, cell_at(low), cell_at(high));
  }
  // On a ring: lay it out as a line, then wrap cells into the period as one stretch or two.
  const auto cells = static_cast<std::int64_t>(divided.cells);
  const std::int64_t low = std::int64_t{code.start[axis]} - static_cast<std::int64_t>(reach);
  const std::int64_t high = std::int64_t{code.start[axis]} + std::int64_t{code.width[axis]};
  const std::int64_t first = low * cells >> 32;  // 2^33 points times 2^20 cells
  const std::int64_t last = high * cells >> 32;
  if (last - first + 1 >= cells) return span.add(axis, 0, cells - 1);
  const std::int64_t from = first < 0 ? first + cells : first;
  const std::int64_t to = last >= cells ? last - cells : last;
  if (from <= to) return span.add(axis, from, to);
  return span.add(axis, from, cells - 1) && span.add(axis, 0, to);
}

std::uint32_t* HierarchicalGrid::gather(std::uint32_t level, const Box& box, const CodedBox& code) {
  // A brick costs about as much as four boxes that are compared one after the other.
  constexpr std::size_t k_brick_cost = 4;
  std::array<Span, 3> spans;
  bool by_cells = level != k_level_unbounded;
  std::size_t bricks = 1;
  for (std::size_t axis = 0; by_cells && axis < 3; ++axis) {
    by_cells = span_of(level, axis, box, code, spans[axis]);
    bricks *= spans[axis].count;
  }
  if (!by_cells || bricks * k_brick_cost > members_[level].size()) return nullptr;
  std::uint32_t* end = gathered_.data();
  for (std::size_t z = 0; z < spans[2].count; ++z) {
    for (std::size_t y = 0; y < spans[1].count; ++y) {
      const std::uint64_t cells = spans[2].cells[z] & spans[1].cells[y];
      for (std::size_t x = 0; x < spans[0].count; ++x) {
        end = bricks_.gather(
            brick_key(level, spans[0].brick[x], spans[1].brick[y], spans[2].brick[z]),
            cells & spans[0].cells[x], end);
      }
    }
  }
  return end;
}

void HierarchicalGrid::widen_reach(std::uint32_t level, const Box& box, const CodedBox& code) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double extent =
        boxes_.periods().periodic(axis) ? static_cast<double>(code.width[axis]) : edge_m(box, axis);
    reach_[level][axis] = std::max(reach_[level][axis], extent);
  }
}

void HierarchicalGrid::place(std::uint32_t body) {
  const Box& box = boxes_.box(body);
  const std::uint32_t level = level_of(box);
  level_[body] = level;
  member_at_[body] = static_cast<std::uint32_t>(members_[level].size());
  members_[level].push_back(body);
  levels_used_ |= std::uint32_t{1} << level;
  if (level == k_level_unbounded) return;
  widen_reach(level, box, boxes_.coded(body));
  bricks_.link(body, address_of(level, box, boxes_.coded(body)), boxes_);
}

void HierarchicalGrid::displace(std::uint32_t body) {
  const std::uint32_t level = level_[body];
  std::vector<std::uint32_t>& members = members_[level];
  members[member_at_[body]] = members.back();
  member_at_[members.back()] = member_at_[body];
  members.pop_back();
  if (level != k_level_unbounded) bricks_.unlink(body, boxes_);
  if (members.empty()) {
    levels_used_ &= ~(std::uint32_t{1} << level);
    reach_[level] = {};
  }
}

void HierarchicalGrid::change(std::uint32_t body, const Box& box, const CodedBox& code) {
  const std::uint32_t level = level_of(box);
  if (level != level_[body]) {
    displace(body);
    boxes_.set(body, box, code);
    place(body);
    return;
  }
  boxes_.set(body, box, code);
  if (level == k_level_unbounded) return;
  widen_reach(level, box, code);
  const CellAddress at = address_of(level, box, code);
  if (at == bricks_.address(body)) return;
  bricks_.unlink(body, boxes_);
  bricks_.link(body, at, boxes_);
}

}  // namespace sleight::physics
