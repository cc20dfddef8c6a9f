// NaN and infinity, for tests in all folders.
#pragma once

#include <limits>

namespace sleight {

inline constexpr double k_infinity = std::numeric_limits<double>::infinity();
inline constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace sleight
