// Which bodies are in which cell of a grid, laid out so that eight boxes are compared at once.
//
// Idea. What a query of a grid costs is memory and wrong guesses of branches, not arithmetic. So a
// cell keeps sketches of its bodies' boxes beside their ids: 16 bits for the start and 16 for the
// width on each axis, in the units and modulo 2^16 of a ring (periodic.h has the idea). Eight
// bodies fill two cache lines, and 13 instructions of SSE2 compare them with a query. Sketches are
// rounded outwards; whom they let pass is compared exactly by the caller.
//
// Cells are numbered modulo a power of two, and whoever numbers them may give several the same
// number. That costs time and no truth, but a query that names a cell twice finds its bodies twice.
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

/// A box on three rings of 2^16 points: on each axis it covers start to start + width.
struct Sketch {
  std::array<std::uint16_t, 3> start{};
  std::array<std::uint16_t, 3> width{};  ///< k_whole_ring covers the ring
};
inline constexpr std::uint16_t k_whole_ring = UINT16_MAX;

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
  std::uint16_t width(std::uint32_t body, std::size_t axis) const {
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
  std::uint32_t next(std::uint32_t block) const { return next_[block]; }
  std::uint32_t body(std::uint32_t block, std::uint32_t slot) const {
    return blocks_[block].body[slot];
  }

  /// A sketch spread out for comparing. Two arcs overlap exactly if the one's last point lies, on
  /// the ring, at most both widths beyond the other's first.
  class Query {
   public:
    explicit Query(const Sketch& sketch) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto last = static_cast<std::uint16_t>(sketch.start[axis] + sketch.width[axis]);
#if defined(__SSE2__)
        last_[axis] = _mm_set1_epi16(static_cast<std::int16_t>(last));
        width_[axis] = _mm_set1_epi16(static_cast<std::int16_t>(sketch.width[axis]));
#else
        last_[axis] = last;
        width_[axis] = sketch.width[axis];
#endif
      }
    }

   private:
    friend class CellTable;
#if defined(__SSE2__)
    __m128i last_[3];
    __m128i width_[3];
#else
    std::uint16_t last_[3];
    std::uint16_t width_[3];
#endif
  };

  /// Bit s says whether slot s of the block holds a body whose sketch overlaps the query.
  std::uint32_t overlapping(std::uint32_t block, const Query& query) const {
    const Block& members = blocks_[block];
#if defined(__SSE2__)
    const auto load = [](const std::array<std::uint16_t, k_slots>& eight) {
      return _mm_load_si128(reinterpret_cast<const __m128i*>(eight.data()));
    };
    // How far beyond both widths, saturated at none.
    const auto beyond = [&](std::size_t axis) {
      const __m128i ahead = _mm_sub_epi16(query.last_[axis], load(members.start[axis]));
      const __m128i widths = _mm_adds_epu16(query.width_[axis], load(members.width[axis]));
      return _mm_subs_epu16(ahead, widths);
    };
    const __m128i apart = _mm_or_si128(_mm_or_si128(beyond(0), beyond(1)), beyond(2));
    const __m128i meet = _mm_cmpeq_epi16(apart, _mm_setzero_si128());
    const int bits = _mm_movemask_epi8(_mm_packs_epi16(meet, _mm_setzero_si128()));
    return static_cast<std::uint32_t>(bits) & filled_[block];
#else
    std::uint32_t bits = 0;
    for (std::uint32_t slot = 0; slot < k_slots; ++slot) {
      bool meet = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto ahead =
            static_cast<std::uint16_t>(query.last_[axis] - members.start[axis][slot]);
        meet &= ahead <= std::uint32_t{query.width_[axis]} + members.width[axis][slot];
      }
      bits |= (meet ? 1U : 0U) << slot;
    }
    return bits & filled_[block];
#endif
  }

 private:
  struct alignas(128) Block {
    std::array<std::array<std::uint16_t, k_slots>, 3> start;
    std::array<std::array<std::uint16_t, k_slots>, 3> width;
    std::array<std::uint32_t, k_slots> body;
  };
  static_assert(sizeof(Block) == 128, "two cache lines, which are fetched together");

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
  std::vector<std::uint32_t> next_;   ///< by block
  std::vector<std::uint32_t> cell_;   ///< by block: whose it is
  std::vector<std::uint32_t> free_;   ///< further blocks that are not in use
  std::vector<std::uint32_t> place_;  ///< by body
};

}  // namespace sleight::physics
