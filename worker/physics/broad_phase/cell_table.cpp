#include "worker/physics/broad_phase/cell_table.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace sleight::physics {
namespace {

/// A non-empty cell contains about five bodies (hierarchical_grid.cpp). So over half of the cell
/// numbers are free, and cells rarely share a number.
constexpr std::uint32_t k_bodies_per_cell = 2;
constexpr std::uint32_t k_cells_least = 64;

}  // namespace

CellTable::CellTable(std::uint32_t bodies)
    : mask_(std::bit_ceil(std::max(bodies / k_bodies_per_cell, k_cells_least)) - 1),
      place_(bodies) {
  const std::uint32_t further = bodies / k_slots;
  const std::size_t blocks = std::size_t{cells()} + further;
  blocks_.resize(blocks);
  filled_.resize(blocks, 0);
  bodies_.resize(blocks);
  cell_.resize(blocks);
  std::iota(cell_.begin(), cell_.end(), 0U);
  free_.resize(further);
  std::iota(free_.rbegin(), free_.rend(), cells());
}

void CellTable::link(std::uint32_t body, std::uint32_t cell, const Sketch& sketch) {
  const std::uint32_t first = cell & mask_;
  // If the first block is full, copy it to a further block: only first blocks have free slots.
  if (filled_[first] == 0xFF) {
    const std::uint32_t further = free_.back();
    free_.pop_back();
    copy_block(first, further);
    cell_[further] = first;
    blocks_[first].next = further;  // the copy links to the former next block
    filled_[further] = 0xFF;
    filled_[first] = 0;
  }
  const auto slot = static_cast<std::uint32_t>(std::countr_one(filled_[first]));
  filled_[first] = static_cast<std::uint8_t>(filled_[first] | 1U << slot);
  place_[body] = first * k_slots + slot;
  bodies_[first][slot] = body;
  write(place_[body], sketch);
}

void CellTable::unlink(std::uint32_t body) {
  // Move the last body of the cell's first block to the removed body's slot.
  const std::uint32_t hole = place_[body];
  const std::uint32_t first = cell_[hole / k_slots];
  const auto last = static_cast<std::uint32_t>(std::countr_one(filled_[first])) - 1;
  Block& to = blocks_[hole / k_slots];
  const Block& from = blocks_[first];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    to.start[axis][hole % k_slots] = from.start[axis][last];
    to.width[axis][hole % k_slots] = from.width[axis][last];
  }
  bodies_[hole / k_slots][hole % k_slots] = bodies_[first][last];
  place_[bodies_[first][last]] = hole;
  filled_[first] = static_cast<std::uint8_t>(filled_[first] >> 1);

  // If the first block is empty now, move a further block of the cell there.
  const std::uint32_t further = blocks_[first].next;
  if (filled_[first] != 0 || further == k_none) return;
  copy_block(further, first);
  filled_[first] = 0xFF;
  filled_[further] = 0;
  free_.push_back(further);
}

void CellTable::copy_block(std::uint32_t from, std::uint32_t to) {
  blocks_[to] = blocks_[from];
  bodies_[to] = bodies_[from];
  for (std::uint32_t slot = 0; slot < k_slots; ++slot)
    place_[bodies_[to][slot]] = to * k_slots + slot;
}

}  // namespace sleight::physics
