#include "worker/physics/contact/rest_log.h"

#include "common/math/vector.h"

namespace sleight::physics {

void RestLog::record(const TouchRecord& touch) {
  std::size_t to = count;
  const double near_m = k_same_place * math::norm(touch.arm_m);
  for (std::size_t i = 0; i < count; ++i) {
    const TouchRecord& other = records[i];
    if (other.partner == touch.partner && math::norm(other.arm_m - touch.arm_m) < near_m &&
        math::dot(other.normal, touch.normal) > 0.9) {
      to = i;
      break;
    }
  }
  if (to == k_touch_records_max) {
    to = 0;
    for (std::size_t i = 1; i < k_touch_records_max; ++i) {
      if (records[i].tick < records[to].tick) to = i;
    }
  } else if (to == count) {
    ++count;
  }
  records[to] = touch;
}

void RestLog::forget_before(Tick now, TickCount span) {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (now - records[i].tick <= span) records[kept++] = records[i];
  }
  count = kept;
}

void RestLog::disturb() {
  rests = false;
  slow_since = k_never;
  due = k_never;
  slow_collisions = 0;
}

}  // namespace sleight::physics
