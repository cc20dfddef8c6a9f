// The level of each replica in each scan: the index process of Syed et al., "Non-reversible
// parallel tempering", 2022. Only displays use it. Replicas that travel from the hottest to the
// coolest level bring new draws there.
//
// The stored scans are the multiples of a stride, which doubles when the number of stored scans
// exceeds a bound. So the set of stored scans depends only on the scans added. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sleight::sampling {

class IndexProcess {
 public:
  static constexpr std::size_t k_moments_max = 1024;
  static constexpr std::uint16_t k_no_level = std::numeric_limits<std::uint16_t>::max();

  struct Moment {
    std::uint64_t scan = 0;
    /// Level by replica, up to the last replica that has a level. Level 0 is the hottest;
    /// k_no_level marks a replica without a level.
    std::vector<std::uint16_t> level;
  };

  /// `replica` is indexed by level. REQUIRES: scans ascend; fewer than k_no_level levels.
  void add(std::uint64_t scan, std::span<const std::uint32_t> replica);

  const std::vector<Moment>& moments() const { return moments_; }

 private:
  std::vector<Moment> moments_;
  std::uint64_t stride_ = 1;
};

}  // namespace sleight::sampling
