// Stores the bodies in each cell of a grid. The layout permits comparing eight boxes at once.
//
// Idea. A grid query spends its time on memory and mispredicted branches, not on arithmetic. So a
// cell stores sketches of its bodies' boxes. A sketch stores a box's start and width on each axis,
// in 8 bits each. Start and width count the points of a ring of 2^8 points (periodic.h explains
// rings). Eight sketches fit one cache line, and some 12 SSE2 instructions compare them with a
// query. Body ids are stored elsewhere, because queries rarely read them: in a gas, a query finds
// at most one body per four blocks. Sketches are rounded outwards; the caller compares the exact
// boxes of the bodies found.
//
// Cells are numbered modulo a power of two, so several cells may share a number. Sharing a number
// costs time and changes no result. If a query lists a number twice, it finds the cell's bodies
// twice.
//
// Invariants
//   1. Block c is the first block of cell c, for c < cells(). The block's bodies fill its slots
//      from the first one on. The first block is empty only if the cell is empty. Further blocks
//      are full.
//   2. For each body b in a cell, place_[b] is block * 8 + slot.
//   3. So the table has at most bodies / 8 further blocks; all memory is allocated at the start.
// Thread safety: none.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace sleight::physics {

/// A point on a ring of 2^8 points.
using RingPoint = std::uint8_t;
/// A box on three rings. On each axis, it covers the points from start to start + width.
struct Sketch {
  std::array<RingPoint, 3> start{};
  std::array<RingPoint, 3> width{};  ///< k_whole_ring covers the ring
};
inline constexpr RingPoint k_whole_ring = UINT8_MAX;

class CellTable {
 public:
  /// Marks the end of a cell's chain of blocks.
  static constexpr std::uint32_t k_none = UINT32_MAX;
  static constexpr std::uint32_t k_slots = 8;

  explicit CellTable(std::uint32_t bodies);

  /// A power of two. Cell numbers count modulo this.
  std::uint32_t cells() const { return mask_ + 1; }

  /// REQUIRES: the body is in no cell.
  void link(std::uint32_t body, std::uint32_t cell, const Sketch& sketch);
  /// REQUIRES: the body is in a cell.
  void unlink(std::uint32_t body);
  /// Replaces a body's sketch and, if it changed, its cell. REQUIRES: the body is in a cell.
  void change(std::uint32_t body, std::uint32_t cell, const Sketch& sketch) {
    const std::uint32_t place = place_[body];
    if (cell_[place / k_slots] == (cell & mask_)) {
      write(place, sketch);
      return;
    }
    unlink(body);
    link(body, cell, sketch);
  }
  /// REQUIRES: the body is in a cell.
  RingPoint width(std::uint32_t body, std::size_t axis) const {
    const std::uint32_t place = place_[body];
    return blocks_[place / k_slots].width[axis][place % k_slots];
  }

  /// If the cell has bodies, writes the number of its first block to `to`, and returns to + 1. If
  /// the cell is empty, returns `to`. REQUIRES: `to` has room for one number, even if the cell is
  /// empty.
  std::uint32_t* add_if_any(std::uint32_t cell, std::uint32_t* to) const {
    *to = cell & mask_;
    return to + (filled_[*to] & 1U);  // invariant 1
  }
  /// Returns the next block of the same cell, or k_none.
  std::uint32_t next(std::uint32_t block) const { return blocks_[block].next; }
  std::uint32_t body(std::uint32_t block, std::uint32_t slot) const { return bodies_[block][slot]; }

  /// A sketch prepared for comparisons. Let d be the distance along the ring from one arc's first
  /// point to the other arc's last point. The arcs overlap exactly if d is at most the sum of both
  /// widths.
  class Query {
   public:
    explicit Query(const Sketch& sketch) {
      std::array<RingPoint, 3> last;
      for (std::size_t axis = 0; axis < 3; ++axis)
        last[axis] = static_cast<RingPoint>(sketch.start[axis] + sketch.width[axis]);
#if defined(__SSE2__)
      const auto spread = [](RingPoint low, RingPoint high) {
        return _mm_unpacklo_epi64(_mm_set1_epi8(static_cast<char>(low)),
                                  _mm_set1_epi8(static_cast<char>(high)));
      };
      last_xy_ = spread(last[0], last[1]);
      last_z_ = spread(last[2], last[2]);
      width_xy_ = spread(sketch.width[0], sketch.width[1]);
      width_z_ = spread(sketch.width[2], sketch.width[2]);
#else
      last_ = last;
      width_ = sketch.width;
#endif
    }

   private:
    friend class CellTable;
#if defined(__SSE2__)
    __m128i last_xy_;  ///< eight times each
    __m128i last_z_;
    __m128i width_xy_;
    __m128i width_z_;
#else
    std::array<RingPoint, 3> last_;
    std::array<RingPoint, 3> width_;
#endif
  };

  /// Returns one bit per slot of the block. The bit is set if the sketch in the slot overlaps the
  /// query.
  std::uint32_t overlapping(std::uint32_t block, const Query& query) const {
    const Block& members = blocks_[block];
#if defined(__SSE2__)
    // The x and y axes share a register; the z axis uses the lower half of another register.
    const auto load = [](const auto& eights) {
      return _mm_loadu_si128(reinterpret_cast<const __m128i*>(&eights));
    };
    const auto load_half = [](const auto& eight) {
      return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(&eight));
    };
    // Compute max(0, distance - sum of both widths).
    const __m128i beyond_xy = _mm_subs_epu8(_mm_sub_epi8(query.last_xy_, load(members.start[0])),
                                            _mm_adds_epu8(query.width_xy_, load(members.width[0])));
    const __m128i beyond_z =
        _mm_subs_epu8(_mm_sub_epi8(query.last_z_, load_half(members.start[2])),
                      _mm_adds_epu8(query.width_z_, load_half(members.width[2])));
    const __m128i apart =
        _mm_or_si128(_mm_or_si128(beyond_xy, _mm_srli_si128(beyond_xy, 8)), beyond_z);
    const int bits = _mm_movemask_epi8(_mm_cmpeq_epi8(apart, _mm_setzero_si128()));
    return static_cast<std::uint32_t>(bits) & filled_[block];
#else
    std::uint32_t bits = 0;
    for (std::uint32_t slot = 0; slot < k_slots; ++slot) {
      bool meet = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto ahead = static_cast<RingPoint>(query.last_[axis] - members.start[axis][slot]);
        meet &= ahead <= std::uint32_t{query.width_[axis]} + members.width[axis][slot];
      }
      bits |= (meet ? 1U : 0U) << slot;
    }
    return bits & filled_[block];
#endif
  }

 private:
  struct alignas(64) Block {
    std::array<std::array<RingPoint, k_slots>, 3> start;
    std::array<std::array<RingPoint, k_slots>, 3> width;
    std::uint32_t next = k_none;
  };
  static_assert(sizeof(Block) == 64);

  void write(std::uint32_t place, const Sketch& sketch) {
    Block& block = blocks_[place / k_slots];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block.start[axis][place % k_slots] = sketch.start[axis];
      block.width[axis][place % k_slots] = sketch.width[axis];
    }
  }
  void copy_block(std::uint32_t from, std::uint32_t to);

  std::uint32_t mask_;
  std::vector<Block> blocks_;         ///< first blocks of all cells, then further blocks
  std::vector<std::uint8_t> filled_;  ///< by block: a bit per slot in use
  std::vector<std::array<std::uint32_t, k_slots>> bodies_;  ///< by block
  std::vector<std::uint32_t> cell_;                         ///< by block: its cell
  std::vector<std::uint32_t> free_;                         ///< unused further blocks
  std::vector<std::uint32_t> place_;                        ///< by body
};

}  // namespace sleight::physics
