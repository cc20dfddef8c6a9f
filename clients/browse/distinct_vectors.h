// Stores equal vectors once, such as the accelerations of falling bodies.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/math/vector.h"

namespace sleight::browse {

/// Rows of bitwise distinct vectors, in order of first use.
class DistinctVectors {
 public:
  std::uint32_t row_of(const math::Vec3& v) {
    const std::array<std::uint64_t, 3> bits{std::bit_cast<std::uint64_t>(v.x()),
                                            std::bit_cast<std::uint64_t>(v.y()),
                                            std::bit_cast<std::uint64_t>(v.z())};
    const auto [found, is_new] = rows_.emplace(bits, static_cast<std::uint32_t>(rows_.size()));
    if (is_new) numbers_.insert(numbers_.end(), v.begin(), v.end());
    return found->second;
  }
  std::span<const double> numbers() const { return numbers_; }

 private:
  std::map<std::array<std::uint64_t, 3>, std::uint32_t> rows_;
  std::vector<double> numbers_;
};

}  // namespace sleight::browse
