// Vectors of four numbers: three coordinates and one more. Used for bounds.
//
// Idea. A path's bounds require the same operations along all three axes. Code without branches
// that does these operations side by side costs at most half as much.
//
// Invariants
//   1. Every operation rounds each number as the same operation on a double does. So vector
//      registers don't change the bits of results.
//   2. dot() and sum() add in another order than math::dot(). So they compute only bounds, which
//      allow for rounding, and never decide a collision.
// Thread safety: values.
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/physics/motion/rigid_body.h"

namespace sleight::physics {

#ifdef __SSE2__

struct Four {
  __m128d xy;
  __m128d zw;

  static Four zero() { return {_mm_setzero_pd(), _mm_setzero_pd()}; }
  /// The fourth number is 0.
  static Four of(const Vec3& v) { return {_mm_loadu_pd(v.data()), _mm_load_sd(v.data() + 2)}; }
  static Four of(const std::array<double, 4>& numbers) {
    return {_mm_loadu_pd(numbers.data()), _mm_loadu_pd(numbers.data() + 2)};
  }
  static Four of(const std::array<float, 4>& numbers) {
    const __m128 whole = _mm_loadu_ps(numbers.data());
    return {_mm_cvtps_pd(whole), _mm_cvtps_pd(_mm_movehl_ps(whole, whole))};
  }
  static Four all(double x) { return {_mm_set1_pd(x), _mm_set1_pd(x)}; }
  /// The fourth number is 0.
  static Four axes(double x) { return {_mm_set1_pd(x), _mm_set_sd(x)}; }
};

inline Four operator+(const Four& a, const Four& b) {
  return {_mm_add_pd(a.xy, b.xy), _mm_add_pd(a.zw, b.zw)};
}
inline Four operator-(const Four& a, const Four& b) {
  return {_mm_sub_pd(a.xy, b.xy), _mm_sub_pd(a.zw, b.zw)};
}
inline Four operator*(const Four& a, const Four& b) {
  return {_mm_mul_pd(a.xy, b.xy), _mm_mul_pd(a.zw, b.zw)};
}
inline Four operator/(const Four& a, const Four& b) {
  return {_mm_div_pd(a.xy, b.xy), _mm_div_pd(a.zw, b.zw)};
}
inline Four min(const Four& a, const Four& b) {
  return {_mm_min_pd(a.xy, b.xy), _mm_min_pd(a.zw, b.zw)};
}
inline Four max(const Four& a, const Four& b) {
  return {_mm_max_pd(a.xy, b.xy), _mm_max_pd(a.zw, b.zw)};
}
inline Four sqrt(const Four& a) {
  return {_mm_sqrt_pd(a.xy), _mm_sqrt_pd(a.zw)};
}
inline Four fabs(const Four& a) {
  const __m128d sign = _mm_set1_pd(-0.0);
  return {_mm_andnot_pd(sign, a.xy), _mm_andnot_pd(sign, a.zw)};
}
/// Returns whether any number has its sign bit set. Some NaNs have it set too.
inline bool is_any_negative(const Four& a) {
  return (_mm_movemask_pd(a.xy) | _mm_movemask_pd(a.zw)) != 0;
}
/// For each of the four numbers, selects `yes` if a < b, otherwise `no`.
inline Four choose_if_less(const Four& a, const Four& b, const Four& yes, const Four& no) {
  const auto choose = [](__m128d less, __m128d if_so, __m128d if_not) {
    return _mm_or_pd(_mm_and_pd(less, if_so), _mm_andnot_pd(less, if_not));
  };
  return {choose(_mm_cmplt_pd(a.xy, b.xy), yes.xy, no.xy),
          choose(_mm_cmplt_pd(a.zw, b.zw), yes.zw, no.zw)};
}
/// Rounds towards 0. REQUIRES: numbers below 2^31.
inline Four whole_part(const Four& a) {
  return {_mm_cvtepi32_pd(_mm_cvttpd_epi32(a.xy)), _mm_cvtepi32_pd(_mm_cvttpd_epi32(a.zw))};
}
/// Adds in the order (x + z) + (y + w).
inline double sum(const Four& a) {
  const __m128d pairs = _mm_add_pd(a.xy, a.zw);
  return _mm_cvtsd_f64(_mm_add_sd(pairs, _mm_unpackhi_pd(pairs, pairs)));
}
inline double least(const Four& a) {
  const __m128d pairs = _mm_min_pd(a.xy, a.zw);
  return _mm_cvtsd_f64(_mm_min_sd(pairs, _mm_unpackhi_pd(pairs, pairs)));
}
/// Rounds to the nearest floats.
inline std::array<float, 4> floats_of(const Four& a) {
  std::array<float, 4> result;
  _mm_storeu_ps(result.data(), _mm_movelh_ps(_mm_cvtpd_ps(a.xy), _mm_cvtpd_ps(a.zw)));
  return result;
}

#else

struct Four {
  std::array<double, 4> x;

  static Four zero() { return {}; }
  static Four of(const Vec3& v) { return {{v.x(), v.y(), v.z(), 0}}; }
  static Four of(const std::array<double, 4>& numbers) { return {numbers}; }
  static Four of(const std::array<float, 4>& numbers) {
    return {{double{numbers[0]}, double{numbers[1]}, double{numbers[2]}, double{numbers[3]}}};
  }
  static Four all(double x) { return {{x, x, x, x}}; }
  static Four axes(double x) { return {{x, x, x, 0}}; }
};

template <class Make>
Four each_of(const Make& make) {
  return {{make(0U), make(1U), make(2U), make(3U)}};
}
inline Four operator+(const Four& a, const Four& b) {
  return each_of([&](std::size_t i) { return a.x[i] + b.x[i]; });
}
inline Four operator-(const Four& a, const Four& b) {
  return each_of([&](std::size_t i) { return a.x[i] - b.x[i]; });
}
inline Four operator*(const Four& a, const Four& b) {
  return each_of([&](std::size_t i) { return a.x[i] * b.x[i]; });
}
inline Four operator/(const Four& a, const Four& b) {
  return each_of([&](std::size_t i) { return a.x[i] / b.x[i]; });
}
inline Four min(const Four& a, const Four& b) {
  return each_of([&](std::size_t i) { return a.x[i] < b.x[i] ? a.x[i] : b.x[i]; });
}
inline Four max(const Four& a, const Four& b) {
  return each_of([&](std::size_t i) { return a.x[i] > b.x[i] ? a.x[i] : b.x[i]; });
}
inline Four sqrt(const Four& a) {
  return each_of([&](std::size_t i) { return std::sqrt(a.x[i]); });
}
inline Four fabs(const Four& a) {
  return each_of([&](std::size_t i) { return std::fabs(a.x[i]); });
}
inline bool is_any_negative(const Four& a) {
  return std::ranges::any_of(a.x, [](double x) { return std::signbit(x); });
}
inline Four choose_if_less(const Four& a, const Four& b, const Four& yes, const Four& no) {
  return each_of([&](std::size_t i) { return a.x[i] < b.x[i] ? yes.x[i] : no.x[i]; });
}
inline Four whole_part(const Four& a) {
  return each_of([&](std::size_t i) { return std::trunc(a.x[i]); });
}
inline double sum(const Four& a) {
  return (a.x[0] + a.x[2]) + (a.x[1] + a.x[3]);
}
inline double least(const Four& a) {
  return std::min(std::min(a.x[0], a.x[2]), std::min(a.x[1], a.x[3]));
}
inline std::array<float, 4> floats_of(const Four& a) {
  return {static_cast<float>(a.x[0]), static_cast<float>(a.x[1]), static_cast<float>(a.x[2]),
          static_cast<float>(a.x[3])};
}

#endif

inline double dot(const Four& a, const Four& b) {
  return sum(a * b);
}

}  // namespace sleight::physics
