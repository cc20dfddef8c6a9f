#include "common/math/elementary.h"

#include <sleef.h>

#include <cmath>

namespace sleight::math {

namespace {

// Below this limit, tan(x) and log1p(x) equal x within a relative error of 2^-60. The next terms of
// their series are x^3/3 and x^2/2. SLEEF's own tan and log1p return 0 or lose digits for denormal
// x.
constexpr double k_identity_max = 0x1p-60;
// From this limit on, 1 + x rounds to x, so log1p(x) is log(x). SLEEF's log1p is infinite near
// 1e307.
constexpr double k_log1p_is_log_min = 0x1p60;

}  // namespace

double sin(double angle_rad) {
  return Sleef_cinz_sind1_u10purec(angle_rad);
}

double cos(double angle_rad) {
  return Sleef_cinz_cosd1_u10purec(angle_rad);
}

double tan(double angle_rad) {
  if (std::fabs(angle_rad) < k_identity_max) return angle_rad;
  return Sleef_cinz_tand1_u10purec(angle_rad);
}

SinCos sincos(double angle_rad) {
  const Sleef_double_2 both = Sleef_cinz_sincosd1_u10purec(angle_rad);
  return {.sin = both.x, .cos = both.y};
}

double exp(double x) {
  return Sleef_cinz_expd1_u10purec(x);
}

double expm1(double x) {
  return Sleef_cinz_expm1d1_u10purec(x);
}

double log(double x) {
  return Sleef_cinz_logd1_u10purec(x);
}

double log1p(double x) {
  if (std::fabs(x) < k_identity_max) return x;
  if (x > k_log1p_is_log_min) return log(x);
  return Sleef_cinz_log1pd1_u10purec(x);
}

double pow(double x, double y) {
  return Sleef_cinz_powd1_u10purec(x, y);
}

double atan2(double y, double x) {
  return Sleef_cinz_atan2d1_u10purec(y, x);
}

double acos(double x) {
  return Sleef_cinz_acosd1_u10purec(x);
}

double asin(double x) {
  return Sleef_cinz_asind1_u10purec(x);
}

double erf(double x) {
  return Sleef_cinz_erfd1_u10purec(x);
}

double erfc(double x) {
  return Sleef_cinz_erfcd1_u15purec(x);
}

}  // namespace sleight::math
