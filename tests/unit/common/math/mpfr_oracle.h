// Measures the error of a double. MPFR computes the exact value with 256 bits.
#pragma once

#include <mpfr.h>

#include <algorithm>
#include <cmath>

namespace sleight::math {

/// Owns one MPFR number of 256 bits. Not copyable.
class Exact {
 public:
  Exact() { mpfr_init2(value_, 256); }
  explicit Exact(double x) : Exact() { mpfr_set_d(value_, x, MPFR_RNDN); }
  ~Exact() { mpfr_clear(value_); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;

  mpfr_ptr get() { return value_; }

 private:
  mpfr_t value_;
};

/// Returns |result - exact| divided by its bound, `k` ulp + 2 * 2^-1074 (elementary.h, invariant
/// 2). An infinite result counts as 2^1024, the first number that is not a double. Two NaNs differ
/// by 0; a NaN and a number differ by infinity.
inline double error_in_bounds(double result, Exact& exact, double k) {
  if (std::isnan(result) || mpfr_nan_p(exact.get())) {
    return std::isnan(result) && mpfr_nan_p(exact.get()) ? 0 : INFINITY;
  }
  if (mpfr_inf_p(exact.get())) return result == mpfr_get_d(exact.get(), MPFR_RNDN) ? 0 : INFINITY;
  constexpr mpfr_exp_t k_smallest = -1074;
  Exact difference(std::isinf(result) ? std::copysign(1.0, result) : result);
  if (std::isinf(result)) {
    mpfr_mul_2si(difference.get(), difference.get(), 1024, MPFR_RNDN);
    // If the exact value is above 2^1024, infinity is right, even if the difference is large.
    if (mpfr_cmpabs(exact.get(), difference.get()) >= 0 &&
        mpfr_signbit(exact.get()) == static_cast<int>(std::signbit(result))) {
      return 0;
    }
  }
  mpfr_sub(difference.get(), difference.get(), exact.get(), MPFR_RNDN);
  // Multiply the error and its bound by 2^-(exponent of an ulp), so that neither underflows.
  const mpfr_exp_t ulp_exponent =
      mpfr_zero_p(exact.get()) ? k_smallest : std::max(mpfr_get_exp(exact.get()) - 53, k_smallest);
  mpfr_mul_2si(difference.get(), difference.get(), -ulp_exponent, MPFR_RNDN);
  const double error_ulp = std::fabs(mpfr_get_d(difference.get(), MPFR_RNDN));
  return error_ulp / (k + std::ldexp(2, static_cast<int>(k_smallest - ulp_exponent)));
}

}  // namespace sleight::math
