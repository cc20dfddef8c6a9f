// A sparse grid of cells, each a list of bodies, kept in bricks of 4 x 4 x 4 cells.
//
// Idea. A hash of single cells costs a search for each of the 27 to 125 cells near a box, most of
// them empty. Bricks share one search among 64 cells, and 64 bits say which of them hold anybody:
// a query takes the bits of its own cells, drops the empty ones at once and walks the rest.
//
// Cells are numbered by 19 + 2 bits per axis, further ones alias to these: who searches compares
// boxes anyway, so that costs a little time and no truth.
//
// Invariants
//   1. A brick is kept exactly while a cell of it holds a body; so bricks are never more than
//      bodies, and room for that many is taken at the start.
//   2. Bit c of a brick's mask says whether cell c holds a body; `heads` of others is not read.
// Thread safety: none.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "worker/physics/broad_phase/body_boxes.h"
#include "worker/physics/broad_phase/flat_table.h"

namespace sleight::physics {

/// The end of a list of bodies; a body that is in no cell.
inline constexpr std::uint32_t k_nobody = UINT32_MAX;

inline constexpr int k_brick_bits = 19;
inline constexpr std::uint64_t k_brick_mask = (std::uint64_t{1} << k_brick_bits) - 1;

/// A cell: its brick's key, and its number within, x + 4 y + 16 z.
struct CellAddress {
  std::uint64_t brick = k_no_key;
  std::uint32_t cell = 0;
  friend constexpr bool operator==(CellAddress, CellAddress) = default;
};

/// The key of a brick; `level` < 64 keeps grids of different cells apart.
constexpr std::uint64_t brick_key(std::uint32_t level, std::uint64_t x, std::uint64_t y,
                                  std::uint64_t z) {
  return ((std::uint64_t{level} << k_brick_bits | (z & k_brick_mask)) << k_brick_bits |
          (y & k_brick_mask))
             << k_brick_bits |
         (x & k_brick_mask);
}

constexpr CellAddress cell_address(std::uint32_t level, std::int64_t x, std::int64_t y,
                                   std::int64_t z) {
  return {
      .brick = brick_key(level, static_cast<std::uint64_t>(x >> 2),
                         static_cast<std::uint64_t>(y >> 2), static_cast<std::uint64_t>(z >> 2)),
      .cell = static_cast<std::uint32_t>((x & 3) | (y & 3) << 2 | (z & 3) << 4)};
}

/// Where a brick is kept.
struct BrickSlot {
  std::uint64_t key = k_no_key;
  std::uint32_t brick = 0;
};

class BrickMap {
 public:
  explicit BrickMap(std::uint32_t bodies) : index_(bodies), slot_(bodies) {
    bricks_.reserve(bodies);
    free_.reserve(bodies);
  }

  /// The next body of the same cell, or k_nobody. It is kept beside the box, since whoever walks a
  /// list reads the boxes.
  static std::uint32_t next(const CodedBox& box) { return box.start[3]; }

  /// `boxes` are those of all bodies. REQUIRES: the body is in no cell.
  void link(std::uint32_t body, CellAddress at, BodyBoxes& boxes);
  /// REQUIRES: the body is in a cell.
  void unlink(std::uint32_t body, BodyBoxes& boxes);

  /// Where a body is. REQUIRES: it is in a cell.
  CellAddress address(std::uint32_t body) const {
    const std::uint32_t slot = slot_[body];
    return {bricks_[slot >> 6].key, slot & 63};
  }

  /// Writes the first bodies of those cells of a brick whose bits are set; returns the end of what
  /// it wrote. REQUIRES: room at `to` for all of them, and k_overrun more.
  std::uint32_t* gather(std::uint64_t key, std::uint64_t cells, std::uint32_t* to) const {
    const BrickSlot* found = index_.find(key);
    if (found == nullptr) return to;
    const Brick& brick = bricks_[found->brick];
    // How many cells hold somebody is anybody's guess, and a wrong guess of the processor costs as
    // much as ten cells. So the heads are written four at a time, whether they count or not.
    std::uint64_t bits = brick.mask & cells;
    do {
      for (int i = 0; i < k_overrun; ++i, bits &= bits - 1) {
        *to = brick.heads[static_cast<std::size_t>(std::countr_zero(bits | k_last_cell))];
        to += bits != 0 ? 1 : 0;
      }
    } while (bits != 0);
    return to;
  }

  static constexpr int k_overrun = 4;

 private:
  /// Keeps countr_zero of no bits within the heads.
  static constexpr std::uint64_t k_last_cell = std::uint64_t{1} << 63;

  struct Brick {
    std::uint64_t key;
    std::uint64_t mask;
    std::array<std::uint32_t, 64> heads;
  };

  FlatTable<BrickSlot> index_;
  std::vector<Brick> bricks_;
  std::vector<std::uint32_t> free_;  ///< bricks that are not in use
  std::vector<std::uint32_t> slot_;  ///< by body: brick * 64 + cell
};

}  // namespace sleight::physics
