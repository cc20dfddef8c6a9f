// Which groups of bodies and static geometry meet.
//
// Things that don't meet pass through each other: they don't collide, may overlap at the start, and
// don't carry each other at rest. Thread safety: a value.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "common/base/check.h"
#include "worker/physics/event/ids.h"

namespace sleight::physics {

/// Groups are 0 to k_groups_max - 1.
inline constexpr std::size_t k_groups_max = 32;

/// A symmetric table of pairs of groups, a group with itself included. Initially all pairs meet.
class CollisionFilter {
 public:
  /// REQUIRES: both groups are below k_groups_max.
  void set_meet(CollisionGroup a, CollisionGroup b, bool meet) {
    CHECK_LT(std::size_t{std::max(a, b).value}, k_groups_max);
    const auto set = [&](CollisionGroup of, CollisionGroup with) {
      const std::uint32_t bit = std::uint32_t{1} << with.value;
      apart_[of.value] = meet ? apart_[of.value] & ~bit : apart_[of.value] | bit;
    };
    set(a, b);
    set(b, a);
  }
  bool meet(CollisionGroup a, CollisionGroup b) const {
    return (apart_[a.value] >> b.value & 1U) == 0;
  }
  /// Whether some groups don't meet.
  bool any() const { return apart_ != CollisionFilter{}.apart_; }
  friend bool operator==(const CollisionFilter&, const CollisionFilter&) = default;

 private:
  std::array<std::uint32_t, k_groups_max> apart_{};  ///< by group: bits of the groups it misses
};

}  // namespace sleight::physics
