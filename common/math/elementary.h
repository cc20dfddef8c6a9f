// Elementary functions with the same bits on every processor. Only this module calls SLEEF.
//
// Idea. Results must not use libm, because glibc selects variants of sin, cos, exp, log, pow, atan2
// and others by the processor, with or without fused multiply-add. The variants round differently,
// so the same binary yields different bits on different machines. SLEEF has "consistent" functions
// (prefix Sleef_cinz, suffix purec) that never fuse and never dispatch.
//
// std::sqrt is safe, because IEEE 754 requires correct rounding, as for + - * /. std::floor,
// std::fabs, std::ldexp and std::copysign are exact. Results must not use std::hypot or the rest of
// <cmath>.
//
// Invariants
//   1. In the default rounding mode (to nearest), a result depends on the argument's bits alone,
//      not on processor, thread or earlier calls.
//   2. |result - exact| <= k ulp + 2 * 2^-1074, where an ulp is the spacing of doubles at the exact
//      value and each function states its k. The second term matters only for denormals.
//      tests/unit/common/math measures this against MPFR.
//   3. Special values follow C's Annex F: f(NaN) is NaN, odd functions preserve the sign of zero,
//      poles are infinite, arguments outside the domain yield NaN. No errno, no exceptions.
// Thread safety: pure functions.
#pragma once

// GCC 12's vectoriser emits fused vfmaddsub even under -ffp-contract=off (seen in rotated(Vec2,
// angle)), so result code must be compiled without FMA.
#ifdef __FMA__
#error "results would depend on the processor: compile without -mfma and -march=native"
#endif

namespace sleight::math {

struct SinCos {
  double sin = 0;
  double cos = 0;
};

/// Sine of any finite angle in radians (SLEEF guarantees angles up to 1e299; the test covers all
/// angles). k = 1.
double sin(double angle_rad);
double cos(double angle_rad);
double tan(double angle_rad);
/// Sine and cosine together. One call of sincos is cheaper than two calls of sin and cos. k = 1,
/// but the bits can differ from the results of sin() and cos(). To reproduce a value exactly, use
/// the same function.
SinCos sincos(double angle_rad);

/// e^x. Returns 0 below -745.14. Returns infinity above 709.78271, although the exact limit is 2e-6
/// higher. Up to 709.78271, k = 1.
double exp(double x);
/// e^x - 1 without cancellation near 0. k = 1.
double expm1(double x);
/// Natural logarithm. k = 1.
double log(double x);
/// log(1 + x) without cancellation near 0. k = 1.
double log1p(double x);
/// x^y. k = 1.
double pow(double x, double y);

/// Angle of the point (x, y) from the x axis, in [-pi, pi] radians. k = 1.
double atan2(double y, double x);
/// For |x| <= 1: inverse cosine, in [0, pi] radians; inverse sine, in [-pi/2, pi/2] radians. k = 1.
double acos(double x);
double asin(double x);

/// 2/sqrt(pi) times the integral of exp(-t^2) from 0 to x. k = 1.
double erf(double x);
/// 1 - erf(x) without cancellation; 0 above 27.23. k = 1.5.
double erfc(double x);

}  // namespace sleight::math
