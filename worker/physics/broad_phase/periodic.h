// Which boxes overlap, in a world that may repeat itself along some axes.
//
// Idea. Along an axis of period L two boxes overlap if any of their images do. Comparing images in
// floating point needs wrapped copies, and each wrap rounds. So boxes are coded as whole numbers on
// a ring of 2^32 points, on which wrapping is what unsigned arithmetic does by itself:
//
//   an axis that repeats    the ring is one period; the box is rounded outwards to its points
//   one that does not       the ring holds all floats in their order (their bits, signs turned
//                           over), so the code is exact; the two infinities are not neighbours, as
//                           the codes of NaNs lie between them
//
// A box covers the points start, start + 1, ..., start + width of each ring. Two of them overlap
// on an axis if one of them holds the other's start; that is two subtractions and two comparisons,
// alike for both sorts of axes.
//
// Invariants
//   1. `overlap` of coded boxes is the only predicate: every broad phase reports exactly the pairs
//      for which it holds.
//   2. It never misses an overlap of the boxes as given. On axes that do not repeat it equals
//      overlap of box.h; on the others it may report boxes that miss by up to 2^-29 of a period.
// Thread safety: values.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "common/base/check.h"
#include "worker/physics/broad_phase/box.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace sleight::physics {

/// The part of an axis' ring that a box covers.
struct Arc {
  std::uint32_t start = 0;
  std::uint32_t width = 0;  ///< points beyond the start; UINT32_MAX covers the ring
  friend constexpr bool operator==(Arc, Arc) = default;
};

constexpr bool overlap(Arc a, Arc b) {
  return b.start - a.start <= a.width || a.start - b.start <= b.width;
}

/// Whether `outer` holds all points of `inner`.
constexpr bool holds(Arc outer, Arc inner) {
  const std::uint32_t offset = inner.start - outer.start;
  return offset <= outer.width && inner.width <= outer.width - offset;
}

/// A box as three arcs, in one half of a cache line. The fourth numbers are the owner's; the
/// predicates don't read them.
struct alignas(32) CodedBox {
  std::array<std::uint32_t, 4> start{};
  std::array<std::uint32_t, 4> width{};
  constexpr Arc arc(std::size_t axis) const { return {start[axis], width[axis]}; }
};

inline bool overlap(const CodedBox& a, const CodedBox& b) {
#if defined(__SSE2__)
  // SSE2 compares signed numbers only; turning over the top bits makes them unsigned ones.
  const auto load = [](const std::array<std::uint32_t, 4>& four) {
    return _mm_load_si128(reinterpret_cast<const __m128i*>(four.data()));
  };
  const __m128i top = _mm_set1_epi32(INT32_MIN);
  const __m128i ahead = _mm_sub_epi32(load(b.start), load(a.start));
  const __m128i behind = _mm_sub_epi32(_mm_setzero_si128(), ahead);
  const __m128i beyond_a =
      _mm_cmpgt_epi32(_mm_xor_si128(ahead, top), _mm_xor_si128(load(a.width), top));
  const __m128i beyond_b =
      _mm_cmpgt_epi32(_mm_xor_si128(behind, top), _mm_xor_si128(load(b.width), top));
  const int apart = _mm_movemask_ps(_mm_castsi128_ps(_mm_and_si128(beyond_a, beyond_b)));
  return (apart & 7) == 0;
#else
  return overlap(a.arc(0), b.arc(0)) && overlap(a.arc(1), b.arc(1)) && overlap(a.arc(2), b.arc(2));
#endif
}

constexpr bool holds(const CodedBox& outer, const CodedBox& inner) {
  return holds(outer.arc(0), inner.arc(0)) && holds(outer.arc(1), inner.arc(1)) &&
         holds(outer.arc(2), inner.arc(2));
}

/// Points of a ring.
inline constexpr double k_ring = 0x1p32;

/// Place of a float in the order of all floats; -0 and 0 share one. REQUIRES: not NaN.
constexpr std::uint32_t ordered(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0F);  // + 0 makes 0 of -0
  return bits ^ (bits >> 31 != 0 ? UINT32_MAX : 0x80000000U);
}

/// The periods of a world.
class Periods {
 public:
  /// Length of the period per axis; 0 for an axis that does not repeat. REQUIRES: each is 0, or
  /// finite and at least 2^-100 m.
  explicit Periods(const std::array<double, 3>& length_m) : length_m_(length_m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (length_m[axis] == 0) continue;
      CHECK(length_m[axis] >= 0x1p-100 && length_m[axis] <= 0x1p200);
      points_per_m_[axis] = k_ring / length_m[axis];
    }
  }

  bool periodic(std::size_t axis) const { return length_m_[axis] != 0; }
  double length_m(std::size_t axis) const { return length_m_[axis]; }
  /// Points of the ring in a metre, on an axis that repeats.
  double points_per_m(std::size_t axis) const { return points_per_m_[axis]; }

  /// On axes that repeat, a box may lie in any period; one that is as long as the period, or that
  /// reaches further than 2^20 periods from the origin, covers the whole ring.
  /// REQUIRES: low <= high on each axis (so no NaN); CHECKed, as a NaN would be a silent miss.
  CodedBox coded(const Box& box) const {
    CodedBox made;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float low = box.low_m[axis];
      const float high = box.high_m[axis];
      CHECK_LE(low, high);
      Arc arc;
      if (periodic(axis)) {
        arc = wrapped(double{low} * points_per_m_[axis], double{high} * points_per_m_[axis]);
      } else {
        arc.start = ordered(low);
        arc.width = ordered(high) - arc.start;
      }
      made.start[axis] = arc.start;
      made.width[axis] = arc.width;
    }
    return made;
  }

 private:
  // Both arguments carry two roundings: at most 2^-52 of themselves, one point at the limit of
  // 2^20 periods. A point on each side covers that, and truncation towards zero takes another.
  static Arc wrapped(double low, double high) {
    constexpr double k_limit = k_ring * 0x1p20;
    if (!(low >= -k_limit && high <= k_limit)) return {0, UINT32_MAX};
    const std::int64_t first = static_cast<std::int64_t>(low) - 2;
    const std::int64_t last = static_cast<std::int64_t>(high) + 2;
    const auto width = std::min<std::int64_t>(last - first, UINT32_MAX);
    return {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(width)};
  }

  std::array<double, 3> length_m_;
  std::array<double, 3> points_per_m_{};
};

/// Invariant 1 for boxes as they are given.
inline bool overlap(const Box& a, const Box& b, const Periods& periods) {
  return overlap(periods.coded(a), periods.coded(b));
}

}  // namespace sleight::physics
