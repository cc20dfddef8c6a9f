// An EventQueue that stores all slots with an event in a heap (slot_heap.h).
//
// Cost: a new key passes at most O(log n) nodes. Four nodes share a cache line. If a key changes
// little and isn't among the least keys, it usually passes about one node. Empty slots cost
// nothing. Invariants and thread safety are the same as in event_queue.h.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/engines/slot_heap.h"
#include "worker/physics/event/event_queue.h"

namespace sleight::physics {

class HeapQueue {
 public:
  void reset(std::uint32_t slot_count) {
    records_.assign(slot_count, SlotRecord{});
    heap_.reset(slot_count);
  }

  void set(Slot slot, const EventKey& key) {
    if (key == k_no_event) [[unlikely]] {
      return erase(slot);
    }
    SlotRecord& record = records_[slot.value];
    record.key = key;
    if (record.place == k_nowhere) {
      heap_.insert(records_.data(), slot.value);
    } else {
      heap_.update(records_.data(), slot.value);
    }
  }

  void erase(Slot slot) {
    SlotRecord& record = records_[slot.value];
    if (record.place == k_nowhere) return;
    heap_.remove(records_.data(), slot.value);
    record.key = k_no_event;
  }

  const EventKey& key_of(Slot slot) const { return records_[slot.value].key; }
  bool empty() const { return heap_.empty(); }
  QueuedEvent least() const { return {records_[heap_.least()].key, Slot{heap_.least()}}; }

 private:
  std::vector<SlotRecord> records_;
  SlotHeap heap_;
};

static_assert(EventQueue<HeapQueue>);

}  // namespace sleight::physics
