// Points in time for KJ's timers, counted from now by the clock. KJ's functions `afterDelay` and
// `timeoutAfter` count from the loop's last wake-up. So after a long callback, or a pause between
// two calls, these functions fire too early.
#pragma once

#include <kj/time.h>
#include <kj/timer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sleight::rpc {

/// Returns a time at least `seconds` from now, for `atTime` and `timeoutAt`.
inline kj::TimePoint from_now(double seconds) {
  const auto us = static_cast<std::int64_t>(std::ceil(std::max(seconds, 0.0) * 1e6));
  return kj::systemPreciseMonotonicClock().now() + us * kj::MICROSECONDS;
}

}  // namespace sleight::rpc
