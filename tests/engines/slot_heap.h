// A heap of slots for HeapQueue, and for the current bucket of CalendarQueue. A node has four
// children.
//
// Idea. Nodes store the tick beside the slot, because ticks decide nearly all comparisons. Four
// siblings fill one cache line. The slot's record has the rest of the key, which the heap reads
// only if ticks are equal. A record stores its node's index, so a key can change in place.
//
// Node p has the children 4p - 8 to 4p - 5, and the root is node 3. This puts siblings into one
// aligned line, as in section 4 of "The influence of caches on the performance of heaps" (LaMarca
// and Ladner, 1996).
//
// Invariants
//   1. No node precedes its parent in the order of QueuedEvent.
//   2. A record's `place` is the node that holds its slot, or k_nowhere if the slot isn't in the
//      heap.
//   3. A node's tick is the tick of its slot's record.
// The caller owns the records, passes the same array to every call, and changes a key only right
// before the call that reports the change. Thread safety: none.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/check.h"
#include "worker/physics/event/event_queue.h"

namespace sleight::physics {

inline constexpr std::uint32_t k_nowhere = UINT32_MAX;

/// A queue's data about a slot: half a cache line.
struct alignas(32) SlotRecord {
  EventKey key = k_no_event;
  std::uint32_t place = k_nowhere;  ///< in a SlotHeap: its node
  std::uint32_t next = k_nowhere;   ///< for the queue's own use
};
static_assert(sizeof(SlotRecord) == 32);

/// Returns whether slot a's event precedes slot b's event. REQUIRES: both events have the same
/// tick.
inline bool precedes_at_same_tick(const SlotRecord* records, std::uint32_t a, std::uint32_t b) {
  const std::strong_ordering order = records[a].key <=> records[b].key;
  return order == 0 ? a < b : order < 0;
}

class SlotHeap {
 public:
  /// Reserves memory for `slot_count` slots and empties the heap. The caller resets the records.
  void reset(std::uint32_t slot_count) {
    CHECK_LE(slot_count, k_slots_max);
    lines_.assign((slot_count + k_root + 3) / 4 + 1, Line{});
    end_ = k_root;
  }

  bool empty() const { return end_ == k_root; }
  /// REQUIRES: not empty.
  std::uint32_t least() const { return node(k_root).slot; }

  /// REQUIRES: the slot is not in the heap.
  void insert(SlotRecord* records, std::uint32_t slot) {
    rise(records, end_++, {records[slot].key.tick.value, slot});
  }

  /// Call after a slot's key has changed. REQUIRES: the slot is in the heap.
  void update(SlotRecord* records, std::uint32_t slot) {
    place(records, records[slot].place, {records[slot].key.tick.value, slot});
  }

  /// Replaces the slot by the last node. REQUIRES: the slot is in the heap.
  void remove(SlotRecord* records, std::uint32_t slot) {
    const std::uint32_t hole = records[slot].place;
    records[slot].place = k_nowhere;
    const Node last = node(--end_);
    if (last.slot != slot) place(records, hole, last);
  }

 private:
  struct Node {
    TickCount tick = 0;
    std::uint32_t slot = k_nowhere;
  };
  struct alignas(64) Line {
    std::array<Node, 4> nodes;
  };
  static constexpr std::uint32_t k_root = 3;

  Node& node(std::uint32_t index) { return lines_[index / 4].nodes[index % 4]; }
  const Node& node(std::uint32_t index) const { return lines_[index / 4].nodes[index % 4]; }

  static bool precedes(const SlotRecord* records, const Node& a, const Node& b) {
    if (a.tick != b.tick) [[likely]] {
      return a.tick < b.tick;
    }
    return precedes_at_same_tick(records, a.slot, b.slot);
  }

  /// Puts `moved` at `hole`, then moves it up or down to its place in the order.
  void place(SlotRecord* records, std::uint32_t hole, Node moved) {
    if (hole != k_root && precedes(records, moved, node(hole / 4 + 2))) {
      rise(records, hole, moved);
    } else {
      sink(records, hole, moved);
    }
  }

  void rise(SlotRecord* records, std::uint32_t hole, Node moved) {
    while (hole != k_root) {
      const std::uint32_t parent = hole / 4 + 2;
      if (!precedes(records, moved, node(parent))) break;
      put(records, hole, node(parent));
      hole = parent;
    }
    put(records, hole, moved);
  }

  void sink(SlotRecord* records, std::uint32_t hole, Node moved) {
    for (;;) {
      const std::uint32_t first = 4 * hole - 8;
      if (first >= end_) break;
      const std::array<Node, 4>& children = lines_[first / 4].nodes;
      std::uint32_t least = 0;
      if (first + 4 <= end_) [[likely]] {
        const std::uint32_t left = precedes(records, children[1], children[0]) ? 1 : 0;
        const std::uint32_t right = precedes(records, children[3], children[2]) ? 3 : 2;
        least = precedes(records, children[right], children[left]) ? right : left;
      } else {
        for (std::uint32_t i = 1; i < end_ - first; ++i) {
          if (precedes(records, children[i], children[least])) least = i;
        }
      }
      if (!precedes(records, children[least], moved)) break;
      put(records, hole, children[least]);
      hole = first + least;
    }
    put(records, hole, moved);
  }

  void put(SlotRecord* records, std::uint32_t index, Node moved) {
    node(index) = moved;
    records[moved.slot].place = index;
  }

  std::vector<Line> lines_;
  std::uint32_t end_ = k_root;  ///< one after the last node
};

}  // namespace sleight::physics
