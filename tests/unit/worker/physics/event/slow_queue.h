// SlowQueue, the reference for all queues, is slow and plain: it looks at every slot.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/physics/event/event_queue.h"

namespace sleight::physics {

class SlowQueue {
 public:
  void reset(std::uint32_t slot_count) { keys_.assign(slot_count, k_no_event); }
  void set(Slot slot, const EventKey& key) { keys_.at(slot.value) = key; }
  void erase(Slot slot) { keys_.at(slot.value) = k_no_event; }
  EventKey key_of(Slot slot) const { return keys_.at(slot.value); }

  bool empty() const {
    for (const EventKey& key : keys_) {
      if (key != k_no_event) return false;
    }
    return true;
  }

  QueuedEvent least() const {
    QueuedEvent least{.key = k_no_event, .slot = Slot{UINT32_MAX}};
    for (std::uint32_t i = 0; i < keys_.size(); ++i) {
      const QueuedEvent event{.key = keys_[i], .slot = Slot{i}};
      if (event < least) least = event;
    }
    return least;
  }

 private:
  std::vector<EventKey> keys_;
};

static_assert(EventQueue<SlowQueue>);

}  // namespace sleight::physics
