// An EventQueue as a calendar: G. Paul, "A complexity O(1) priority queue for event driven
// molecular dynamics simulations", Journal of Computational Physics 221 (2007), with changes.
//
// Idea. Buckets of equal width divide future time, so that each holds about one event. Only the
// current bucket is ordered, as a heap. The other buckets are lists, so most key changes only move
// a slot from one list to another. If an event comes after the last bucket, it is `far` and in no
// list.
//
// An epoch ends with the last bucket. The queue then scans all slots and lays out new buckets from
// the earliest event on. A sample of waiting events determines the buckets' width. Paul's queue
// instead reuses buckets in a circle, fixes their width by hand, and stores a list of far events.
//
// Invariants, in addition to event_queue.h
//   1. An event's tick determines its location. If the event's bucket isn't after the current
//      bucket, the event is in the heap. An event after all buckets is far. Any other event is in
//      its bucket's list.
//   2. The heap is empty only if the queue is empty.
//   3. A bucket's bit in `occupied_` is set if and only if the bucket's list isn't empty.
// A wrong width only costs time. Wide buckets leave the work to the heap; narrow buckets make
// epochs short. After a short epoch, buckets become at least four times as wide as before. Time:
// O(1) amortised if events spread over time. The call that begins an epoch scans all slots. Memory:
// 64 to 80 bytes per slot. Thread safety: as for event_queue.h.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/engines/slot_heap.h"
#include "worker/physics/event/event_queue.h"

namespace sleight::physics {

class CalendarQueue {
 public:
  void reset(std::uint32_t slot_count);

  void set(Slot slot, const EventKey& key) {
    SlotRecord& record = records_[slot.value];
    if (key == k_no_event) [[unlikely]] {
      return erase(slot);
    }
    ++changes_;
    const std::uint64_t from = record.key == k_no_event ? k_empty : bucket_of(record.key.tick);
    const std::uint64_t to = bucket_of(key.tick);
    if (from == k_empty) {
      ++size_;
    } else if (from <= current_ && to <= current_) {
      record.key = key;
      return heap_.update(records_.data(), slot.value);
    } else if (from == to) {
      record.key = key;
      return;
    }
    take_out(slot.value, from);
    record.key = key;
    put_in(slot.value, to);
    if (heap_.empty()) advance();
  }

  void erase(Slot slot) {
    SlotRecord& record = records_[slot.value];
    if (record.key == k_no_event) return;
    ++changes_;
    take_out(slot.value, bucket_of(record.key.tick));
    record.key = k_no_event;
    --size_;
    if (heap_.empty()) advance();
  }

  const EventKey& key_of(Slot slot) const { return records_[slot.value].key; }
  bool empty() const { return size_ == 0; }
  QueuedEvent least() const { return {records_[heap_.least()].key, Slot{heap_.least()}}; }

 private:
  static constexpr std::uint64_t k_empty = UINT64_MAX;

  /// Returns the bucket of a tick, or buckets() for far ticks.
  std::uint64_t bucket_of(Tick tick) const {
    if (tick <= base_) return 0;
    // Use unsigned numbers, because the signed difference of two ticks may overflow.
    const std::uint64_t since =
        static_cast<std::uint64_t>(tick.value) - static_cast<std::uint64_t>(base_.value);
    const std::uint64_t bucket = since >> shift_;
    return bucket < heads_.size() ? bucket : heads_.size();
  }

  void take_out(std::uint32_t slot, std::uint64_t bucket) {
    if (bucket <= current_) {
      heap_.remove(records_.data(), slot);
    } else if (bucket < heads_.size()) {
      unlink(slot, bucket);
    }
  }

  void put_in(std::uint32_t slot, std::uint64_t bucket) {
    if (bucket <= current_) {
      heap_.insert(records_.data(), slot);
    } else if (bucket < heads_.size()) {
      link(slot, bucket);
    }
  }

  // Doubly linked lists: `place` is the previous slot. The first slot has k_nowhere.
  void link(std::uint32_t slot, std::uint64_t bucket) {
    std::uint32_t& head = heads_[bucket];
    records_[slot].place = k_nowhere;
    records_[slot].next = head;
    if (head == k_nowhere) {
      occupied_[bucket / 64] |= std::uint64_t{1} << bucket % 64;
    } else {
      records_[head].place = slot;
    }
    head = slot;
  }

  void unlink(std::uint32_t slot, std::uint64_t bucket) {
    const std::uint32_t before = records_[slot].place;
    const std::uint32_t after = records_[slot].next;
    if (after != k_nowhere) records_[after].place = before;
    if (before != k_nowhere) {
      records_[before].next = after;
      return;
    }
    heads_[bucket] = after;
    if (after == k_nowhere) occupied_[bucket / 64] &= ~(std::uint64_t{1} << bucket % 64);
  }

  /// Advances to the next bucket that isn't empty. REQUIRES: the heap is empty.
  void advance();
  /// REQUIRES: all events are far.
  void begin_epoch();
  std::uint32_t wanted_shift(Tick earliest) const;

  std::vector<SlotRecord> records_;
  SlotHeap heap_;
  std::vector<std::uint32_t> heads_;     ///< heads of the buckets' lists
  std::vector<std::uint64_t> occupied_;  ///< a bit per bucket
  std::uint64_t current_ = 0;            ///< the bucket whose events are in the heap
  Tick base_{};                          ///< start of bucket 0
  std::uint32_t shift_ = 0;              ///< a bucket is 2^shift_ ticks wide
  std::uint32_t size_ = 0;               ///< number of slots with an event
  std::uint64_t changes_ = 0;            ///< since the epoch began
};

static_assert(EventQueue<CalendarQueue>);

}  // namespace sleight::physics
