// Many sorts of boxes. Tests move the boxes by random scripts and compare the overlaps with the
// definition.
#pragma once

#include <string>
#include <vector>

#include "common/random/stream.h"
#include "worker/physics/broad_phase/broad_phase.h"

namespace sleight::physics {

class Dice {
 public:
  explicit Dice(std::uint64_t index)
      : stream_({.seed = 20260, .purpose = random::Purpose::prior}, index) {}
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>((stream_.bits() >> 32) * count >> 32);
  }
  bool once_in(std::uint32_t count) { return below(count) == 0; }
  double between(double low, double high) { return low + (high - low) * stream_.uniform(); }

 private:
  random::Stream stream_;
};

/// A sort of boxes. `fresh` draws a box anywhere; `moved` draws a body's next box.
struct Scene {
  std::string name;
  std::array<double, 3> period_m{};
  double size_m = 1;
  Box (*fresh)(Dice&) = nullptr;
  Box (*moved)(Dice&, const Box&) = nullptr;
};

/// Scenes without periods: gas, stretched boxes, corners, a pile, six decades of sizes, touching
/// boxes, points, infinite boxes and distant boxes. Other scenes have periods on one, two or three
/// axes.
const std::vector<Scene>& scenes();

}  // namespace sleight::physics
