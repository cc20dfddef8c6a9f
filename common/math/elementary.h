// Elementary functions that give the same bits on every processor: the only place that calls SLEEF.
//
// Idea. libm may not be used for results: glibc looks at the processor when a program starts and
// picks, for sin, cos, exp, log, pow, atan2 and others, a variant with or without fused
// multiply-add. The variants round differently, so one binary gives other bits on another machine.
// SLEEF ships "consistent" functions (prefix Sleef_cinz, suffix purec) that never fuse and never
// dispatch; Sleight computes every transcendental of a result with them.
//
// std::sqrt needs no such care: IEEE 754 demands its correctly rounded value, as it does for
// + - * /; and std::floor, std::fabs, std::ldexp and std::copysign are exact. These may be used
// freely. std::hypot and the rest of <cmath> may not.
//
// Invariants
//   1. A result depends on the argument's bits alone: not on processor, thread or earlier calls
//      (in the default rounding mode, to nearest).
//   2. |result - exact| <= k ulp + 2 * 2^-1074, where an ulp is the spacing of doubles at the exact
//      value and k stands at each function. The second term matters only among the denormals.
//      tests/unit/common/math measures this against MPFR.
//   3. Special values are those of C's Annex F: f(NaN) is NaN, odd functions keep the sign of zero,
//      poles give infinities, arguments outside the domain give NaN. No errno, no exceptions.
// Thread safety: pure functions.
#pragma once

// GCC 12's vectoriser makes fused vfmaddsub of two products and sums even under -ffp-contract=off
// (seen in rotated(Vec2, angle)), so code that computes results is not compiled for FMA at all.
#ifdef __FMA__
#error "results would depend on the processor: compile without -mfma and -march=native"
#endif

namespace sleight::math {

struct SinCos {
  double sin = 0;
  double cos = 0;
};

/// Of an angle in radians, any finite value (SLEEF promises 1e299; the test covers all). k = 1.
double sin(double angle_rad);
double cos(double angle_rad);
double tan(double angle_rad);
/// Both at once, cheaper than two calls. k = 1, but not always the bits that sin() and cos() give:
/// code that must reproduce a value calls the same function again.
SinCos sincos(double angle_rad);

/// e^x: 0 below -745.14, infinity above 709.78271, which is 2e-6 early. Up to there k = 1.
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
/// In [0, pi] and [-pi/2, pi/2] radians, for |x| <= 1. k = 1.
double acos(double x);
double asin(double x);

/// 2/sqrt(pi) times the integral of exp(-t^2) from 0 to x. k = 1.
double erf(double x);
/// 1 - erf(x) without cancellation; 0 above 27.23. k = 1.5.
double erfc(double x);

}  // namespace sleight::math
