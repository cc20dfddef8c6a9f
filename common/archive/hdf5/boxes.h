// Splits a run of elements in row-major order into boxes that fit HDF5's hyperslabs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/check.h"

namespace sleight::archive::hdf5 {

/// A box's `start` and `count` by dimension, for H5Sselect_hyperslab. Empty for a scalar.
struct Box {
  std::vector<std::uint64_t> start;
  std::vector<std::uint64_t> count;
  std::uint64_t elements = 1;
};

/// Returns a box of an array with dimensions `dims`: the largest box that starts at element
/// `first`, is contiguous, and has at most `count` elements. REQUIRES: count >= 1; `first` is
/// within the array.
inline Box box_at(const std::vector<std::uint64_t>& dims, std::uint64_t first,
                  std::uint64_t count) {
  CHECK_GE(count, 1U);
  const std::size_t rank = dims.size();
  Box box{.start = std::vector<std::uint64_t>(rank, 0),
          .count = std::vector<std::uint64_t>(rank, 1),
          .elements = 1};
  for (std::size_t d = rank; d-- > 0;) {
    box.start[d] = first % dims[d];
    first /= dims[d];
  }
  // If the box contains a whole inner dimension, extend the box along the next outer dimension.
  for (std::size_t d = rank; d-- > 0;) {
    const std::uint64_t left = dims[d] - box.start[d];
    box.count[d] = left < count ? left : count;
    box.elements *= box.count[d];
    if (box.count[d] != dims[d]) break;
    count /= dims[d];
  }
  return box;
}

}  // namespace sleight::archive::hdf5
