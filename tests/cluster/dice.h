// Random choices of a simulated cluster. The choices depend only on the seed and the order of
// calls. Each part has its own dice, so that changing a part leaves others' draws unchanged. Not
// thread-safe.
#pragma once

#include <cstdint>

#include "common/math/elementary.h"
#include "common/random/stream.h"

namespace sleight::cluster {

class Dice {
 public:
  enum class Part : std::uint32_t { scenario = 1, faults, network, coordinator, store };

  Dice(std::uint64_t seed, Part part)
      : stream_({.seed = seed, .purpose = random::Purpose::prior},
                static_cast<std::uint64_t>(part)) {}

  double uniform(double least, double most) { return least + (most - least) * stream_.uniform(); }
  double log_uniform(double least, double most) {
    return math::exp(uniform(math::log(least), math::log(most)));
  }
  bool chance(double probability) { return stream_.uniform() < probability; }
  /// REQUIRES: least <= most.
  std::uint64_t whole(std::uint64_t least, std::uint64_t most) {
    return least + stream_.bits() % (most - least + 1);
  }

 private:
  random::Stream stream_;
};

}  // namespace sleight::cluster
