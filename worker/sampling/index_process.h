// At which level of a ladder each replica is, scan after scan: replicas that travel between the
// hottest and the coolest level bring new draws there (Syed et al., "Non-reversible parallel
// tempering", 2022, call this the index process). For people to look at; nothing hangs on it.
//
// Idea. Every scan is kept up to a bound, then every second one, then every fourth: those that are
// multiples of a stride. So what is kept is a function of the scans that were added, and never more
// than the bound.
//
// Not thread-safe.
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
    /// By replica, as far as one of them has had a level; 0 is the hottest, k_no_level: none.
    std::vector<std::uint16_t> level;
  };

  /// `replica`: by level. REQUIRES: scans ascend; fewer than k_no_level levels.
  void add(std::uint64_t scan, std::span<const std::uint32_t> replica);

  const std::vector<Moment>& moments() const { return moments_; }

 private:
  std::vector<Moment> moments_;
  std::uint64_t stride_ = 1;
};

}  // namespace sleight::sampling
