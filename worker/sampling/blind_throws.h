// Makes blind throws to compare with found states.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/random/stream.h"

namespace sleight::sampling {

/// Returns log p_w of `count` states that `draw` makes. Every call returns the same values.
template <class World, class Draw>
std::vector<double> log_priors_of_throws(const World& world, std::size_t count, const Draw& draw) {
  std::vector<double> all;
  for (std::uint64_t nth = 0; nth < count; ++nth) {
    random::Stream stream({.purpose = random::Purpose::blind_throw}, nth);
    all.push_back(world.log_prior(draw(stream)));
  }
  return all;
}

}  // namespace sleight::sampling
