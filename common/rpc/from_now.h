// Times of KJ's timers, counted from now by the clock. KJ's own `afterDelay` and `timeoutAfter`
// count from when the loop last woke: after a callback, or a pause between two calls, that took
// long, they come early.
#pragma once

#include <kj/time.h>
#include <kj/timer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sleight::rpc {

/// Never earlier than so long from now; to be given to `atTime` and `timeoutAt`.
inline kj::TimePoint from_now(double seconds) {
  const auto us = static_cast<std::int64_t>(std::ceil(std::max(seconds, 0.0) * 1e6));
  return kj::systemPreciseMonotonicClock().now() + us * kj::MICROSECONDS;
}

}  // namespace sleight::rpc
