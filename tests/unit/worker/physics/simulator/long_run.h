// Whether tests run at the length of deploy/soak, and not at that of each run.
#pragma once

#include <cstdlib>

namespace sleight::physics::testing {

inline bool long_run() {
  return std::getenv("SLEIGHT_SOAK") != nullptr;
}

}  // namespace sleight::physics::testing
