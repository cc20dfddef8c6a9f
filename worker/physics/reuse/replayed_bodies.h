// Which bodies of a simulation are replayed (replay.h), and which have ceased to be.
//
// Thread safety: none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/physics/event/ids.h"

namespace sleight::physics {

class ReplayedBodies {
 public:
  /// None of so many.
  void reset(std::size_t bodies) { is_replayed_.assign(bodies, 0); }
  bool any() const { return count_ != 0; }
  bool has(BodyId body) const { return count_ != 0 && is_replayed_[body] != 0; }
  /// REQUIRES: it isn't.
  void add(BodyId body) {
    is_replayed_[body] = 1;
    ++count_;
  }
  /// From now on it is simulated, if it was replayed.
  void make_live(BodyId body) {
    if (!has(body)) return;
    is_replayed_[body] = 0;
    --count_;
    gone_live_.push_back(body);
  }
  /// Since the last forget_gone_live.
  std::span<const BodyId> gone_live() const { return gone_live_; }
  void forget_gone_live() { gone_live_.clear(); }

 private:
  std::vector<std::uint8_t> is_replayed_;
  std::uint32_t count_ = 0;
  std::vector<BodyId> gone_live_;
};

}  // namespace sleight::physics
