// At what length tests run: that of deploy/soak or that of each run; all cases, or one to be seen
// again.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace sleight::physics::testing {

inline bool long_run() {
  return std::getenv("SLEIGHT_SOAK") != nullptr;
}

/// From the first up to, and without, the last.
struct Cases {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  bool all = true;  ///< so that what they say together can be asked for
};

/// The one that an environment variable names, or all.
inline Cases cases_of(const char* variable, std::uint64_t count) {
  const char* const one = std::getenv(variable);
  if (one == nullptr) return {.first = 0, .last = count, .all = true};
  const std::uint64_t n = std::strtoull(one, nullptr, 10);
  return {.first = n, .last = n + 1, .all = false};
}

}  // namespace sleight::physics::testing
