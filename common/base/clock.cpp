#include "common/base/clock.h"

#include <chrono>
#include <ctime>

namespace sleight::base {
namespace {

double time_of(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

double SteadyClock::now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double BootClock::now_s() const {
  return time_of(CLOCK_BOOTTIME);
}

double thread_processor_s() {
  return time_of(CLOCK_THREAD_CPUTIME_ID);
}

}  // namespace sleight::base
