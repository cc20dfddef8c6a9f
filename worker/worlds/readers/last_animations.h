// Caches the last requested animations. The choice of kept animations compares each new animation
// with the same few animations. Thread-safe.
#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "worker/worlds/readers/played_out.h"

namespace sleight::worlds {

template <class World>
class LastAnimations {
 public:
  using Animation =
      decltype(std::declval<const World&>().animate(std::declval<const typename World::State&>()));

  /// REQUIRES: all calls have the same world, and its worker produced `bytes`.
  std::shared_ptr<const Animation> of(const World& world, base::BytesView bytes) {
    {
      const std::lock_guard lock(mutex_);
      for (const Held& held : held_) {
        if (std::ranges::equal(held.bytes, bytes)) return held.animation;
      }
    }
    auto animation = std::make_shared<const Animation>(world.animate(decoded(world, bytes)));
    const std::lock_guard lock(mutex_);
    held_.push_back({base::Bytes(bytes.begin(), bytes.end()), animation});
    if (held_.size() > k_held) held_.pop_front();
    return animation;
  }

 private:
  /// Several times the number stored per lineage. Uses a few megabytes for twenty dice.
  static constexpr std::size_t k_held = 16;
  struct Held {
    base::Bytes bytes;
    std::shared_ptr<const Animation> animation;
  };
  std::mutex mutex_;
  std::deque<Held> held_;
};

}  // namespace sleight::worlds
