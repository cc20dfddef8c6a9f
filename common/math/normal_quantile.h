// The standard normal quantile function, with the same bits on every processor.
//
// Method: Wichura, "Algorithm AS 241: the percentage points of the normal distribution", Applied
// Statistics 37 (1988) 477-484, routine PPND16: three rational approximations, one around the
// median and two in sqrt(-log of the tail). The logarithm is common/math's. Thread safety: pure
// functions.
#pragma once

namespace sleight::math {

/// Returns x such that a standard normal variable is below x with the given probability. The
/// relative error is below 1e-15. The bits equal those of R's qnorm wherever both programs compute
/// the same logarithm. The result is infinite at 0 and 1, and NaN outside [0, 1] and for NaN. The
/// function is odd about 1/2, where it is 0. Close to 1, doubles are too coarse for the
/// probability; use -normal_quantile(1 - probability).
double normal_quantile(double probability);

}  // namespace sleight::math
