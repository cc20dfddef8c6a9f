// Which bodies are in which cell of a grid, laid out so that eight boxes are compared at once.
//
// Idea. A query of a grid spends its time on memory and on branches guessed wrong, not on
// arithmetic. So a cell keeps sketches of its bodies' boxes: 8 bits for the start and 8 for the
// width on each axis, in the units and modulo 2^8 of a ring (periodic.h has the idea). Eight bodies
// fit one cache line, and some 12 instructions of SSE2 compare them with a query. Their ids lie
// elsewhere: a query of a gas finds one body or less in four blocks. Sketches are rounded outwards;
// the caller compares the bodies that pass exactly.
//
// Cells are numbered modulo a power of two, and several cells may have one number. That costs time
// and changes no result, but a query that names a cell twice finds its bodies twice.
//
// Invariants
//   1. Block c is the first of cell c, for c < cells(). Its members fill its slots from the first
//      on; it is empty only if the cell is. Further blocks of the cell are full.
//   2. place_[b] is block * 8 + slot of each body in a cell.
//   3. So there are at most bodies / 8 further blocks; all memory is taken at the start.
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

/// A place on a ring of 2^8 points.
using RingPoint = std::uint8_t;
/// A box on three rings: on each axis it covers start to start + width.
struct Sketch {
  std::array<RingPoint, 3> start{};
  std::array<RingPoint, 3> width{};  ///< k_whole_ring covers the ring
};
inline constexpr RingPoint k_whole_ring = UINT8_MAX;

class CellTable {
 public:
  /// No block: the end of a cell's chain.
  static constexpr std::uint32_t k_none = UINT32_MAX;
  static constexpr std::uint32_t k_slots = 8;

  explicit CellTable(std::uint32_t bodies);

  /// A power of two. Cells are given by any number; it counts modulo this.
  std::uint32_t cells() const { return mask_ + 1; }

  /// REQUIRES: the body is in no cell.
  void link(std::uint32_t body, std::uint32_t cell, const Sketch& sketch);
  /// REQUIRES: the body is in a cell.
  void unlink(std::uint32_t body);
  /// Replaces the sketch of a body, which may be in another cell now. REQUIRES: it is in a cell.
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

  /// Appends a cell's first block at `to` if it holds anybody; returns the end. REQUIRES: room for
  /// one, which may be written in any case.
  std::uint32_t* add_if_any(std::uint32_t cell, std::uint32_t* to) const {
    *to = cell & mask_;
    return to + (filled_[*to] & 1U);  // invariant 1
  }
  /// The next block of the same cell, or k_none.
  std::uint32_t next(std::uint32_t block) const { return blocks_[block].next; }
  std::uint32_t body(std::uint32_t block, std::uint32_t slot) const { return bodies_[block][slot]; }

  /// A sketch spread out for comparing. Two arcs overlap exactly if the one's last point lies, on
  /// the ring, at most both widths beyond the other's first.
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

  /// Bit s says whether slot s of the block holds a body whose sketch overlaps the query.
  std::uint32_t overlapping(std::uint32_t block, const Query& query) const {
    const Block& members = blocks_[block];
#if defined(__SSE2__)
    // x and y in one register; of z, the start in the lower half of one.
    const auto load = [](const auto& eights) {
      return _mm_loadu_si128(reinterpret_cast<const __m128i*>(&eights));
    };
    const auto load_half = [](const auto& eight) {
      return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(&eight));
    };
    // How far beyond both widths, saturated at none.
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
  std::vector<Block> blocks_;         ///< first ones of all cells, then further ones
  std::vector<std::uint8_t> filled_;  ///< by block: bit per slot in use
  std::vector<std::array<std::uint32_t, k_slots>> bodies_;  ///< by block
  std::vector<std::uint32_t> cell_;                         ///< by block: whose it is
  std::vector<std::uint32_t> free_;                         ///< further blocks that are not in use
  std::vector<std::uint32_t> place_;                        ///< by body
};

}  // namespace sleight::physics
