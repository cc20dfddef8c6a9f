// The doubles nearest to pi and to 2 pi; k_pi is 1.2e-16 below pi.
#pragma once

namespace sleight::math {

constexpr double k_pi = 0x1.921fb54442d18p+1;
constexpr double k_two_pi = 0x1.921fb54442d18p+2;

}  // namespace sleight::math
