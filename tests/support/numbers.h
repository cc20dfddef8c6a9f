// NaN and infinity, for all folders' tests.
#pragma once

#include <limits>

namespace sleight {

inline constexpr double k_infinity = std::numeric_limits<double>::infinity();
inline constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace sleight
