// Constants that the log densities share.
#pragma once

#include <limits>

namespace sleight::random {

/// The log density outside a distribution's support.
inline constexpr double k_outside = -std::numeric_limits<double>::infinity();
inline constexpr double k_half_log_two_pi = 0x1.d67f1c864beb5p-1;  // 0.91893853320467274
inline constexpr double k_sqrt_two_pi = 0x1.40d931ff62706p+1;      // 2.5066282746310002

}  // namespace sleight::random
