// Throws as a person would make them, blindly: what a state that was found is compared with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/random/stream.h"

namespace sleight::sampling {

/// log p_w of so many states that `draw` draws from a stream; the same ones at every call.
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
