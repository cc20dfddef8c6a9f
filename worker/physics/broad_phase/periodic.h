// Decides which boxes overlap, in a world that may repeat along some axes.
//
// Idea. Two boxes overlap along an axis of period L if any of their images do. Comparing images in
// floating point requires wrapped copies, and each wrap rounds. So boxes are coded as integers on a
// ring of 2^32 points, on which unsigned arithmetic wraps by itself:
//
//   - On a repeating axis, the ring is one period, and a box is rounded outwards to ring points.
//   - On a non-repeating axis, the points of the ring are all floats in ascending order, so the
//     code is exact. The codes of NaNs are between the codes of the two infinities.
//
// A box covers the points start, start + 1, ..., start + width of each ring. Two boxes overlap on
// an axis if one of them contains the other's start. On both kinds of axes, the test takes two
// subtractions and two comparisons.
//
// Invariants
//   1. Every broad phase reports exactly the pairs whose coded boxes satisfy `overlap`.
//   2. `overlap` never misses an overlap of the plain boxes. On non-repeating axes, `overlap` of
//      coded boxes equals `overlap` of plain boxes (box.h). On repeating axes, `overlap` may accept
//      boxes that are apart by up to 2^-29 of a period.
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

/// The part of a ring that a box covers.
struct Arc {
  std::uint32_t start = 0;
  std::uint32_t width = 0;  ///< points beyond the start; UINT32_MAX covers the ring
  friend constexpr bool operator==(Arc, Arc) = default;
};

constexpr bool overlap(Arc a, Arc b) {
  return b.start - a.start <= a.width || a.start - b.start <= b.width;
}

constexpr bool holds(Arc outer, Arc inner) {
  const std::uint32_t offset = inner.start - outer.start;
  return offset <= outer.width && inner.width <= outer.width - offset;
}

/// A box as three arcs, in half a cache line. The owner may use the fourth numbers; functions here
/// ignore them.
struct alignas(32) CodedBox {
  std::array<std::uint32_t, 4> start{};
  std::array<std::uint32_t, 4> width{};
  constexpr Arc arc(std::size_t axis) const { return {start[axis], width[axis]}; }
};

inline bool overlap(const CodedBox& a, const CodedBox& b) {
#if defined(__SSE2__)
  // SSE2 only compares signed numbers; inverting the top bits makes the comparison unsigned.
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

/// Number of points of a ring.
inline constexpr double k_ring = 0x1p32;

/// Returns a float's place in the order of all floats; -0 and 0 share a place. REQUIRES: not NaN.
constexpr std::uint32_t ordered(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0F);  // + 0 makes 0 of -0
  return bits ^ (bits >> 31 != 0 ? UINT32_MAX : 0x80000000U);
}

class Periods {
 public:
  /// `length_m`: each axis's period; 0 if the axis doesn't repeat. REQUIRES: 0, or finite and >=
  /// 2^-100 m.
  explicit Periods(const std::array<double, 3>& length_m) : length_m_(length_m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (length_m[axis] == 0) continue;
      CHECK(length_m[axis] >= 0x1p-100 && length_m[axis] <= 0x1p200);
      points_per_m_[axis] = k_ring / length_m[axis];
    }
  }

  bool periodic(std::size_t axis) const { return length_m_[axis] != 0; }
  double length_m(std::size_t axis) const { return length_m_[axis]; }
  /// 0 if the axis does not repeat.
  double points_per_m(std::size_t axis) const { return points_per_m_[axis]; }

  /// Returns a box's code. On repeating axes, a box may be in any period. A box covers the whole
  /// ring if it is as long as the period, or more than 2^20 periods from the origin. REQUIRES:
  /// low_m <= high_m on each axis. coded() CHECKs this order, because a NaN would otherwise hide
  /// overlaps.
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
  // Two roundings change each argument by at most 2^-52 of its size. At 2^20 periods, this is one
  // ring point. One extra point on each side covers this error, and a second one covers truncation
  // to zero.
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

/// Returns whether the codes of two plain boxes overlap (invariant 1).
inline bool overlap(const Box& a, const Box& b, const Periods& periods) {
  return overlap(periods.coded(a), periods.coded(b));
}

}  // namespace sleight::physics
