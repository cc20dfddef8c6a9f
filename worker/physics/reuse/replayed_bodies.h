// Stores which bodies are replayed (replay.h), and lists the bodies that have gone live.
//
// Fixed bodies never go live. They count as replayed while another body is replayed: so contacts
// with them aren't predicted for replayed bodies, and live bodies touch them without effect on
// replayed ones.
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
  void reset(std::size_t bodies) { is_replayed_.assign(bodies, 0); }
  bool any() const { return count_ != 0; }
  bool has(BodyId body) const { return count_ != 0 && is_replayed_[body] != 0; }
  /// REQUIRES: the body isn't replayed.
  void add(BodyId body, bool fixed) {
    is_replayed_[body] = fixed ? k_fixed : 1;
    if (!fixed) ++count_;
  }
  /// Makes a replayed body live; no effect on a live body.
  void make_live(BodyId body) {
    if (!has(body) || is_replayed_[body] == k_fixed) return;
    is_replayed_[body] = 0;
    --count_;
    gone_live_.push_back(body);
  }
  /// Bodies that have gone live since the last forget_gone_live().
  std::span<const BodyId> gone_live() const { return gone_live_; }
  void forget_gone_live() { gone_live_.clear(); }

 private:
  static constexpr std::uint8_t k_fixed = 2;
  std::vector<std::uint8_t> is_replayed_;
  std::uint32_t count_ = 0;
  std::vector<BodyId> gone_live_;
};

}  // namespace sleight::physics
