// An EventQueue as a tournament. Slots compete in groups of eight, and the groups' winners compete
// in pairs. The overall winner is the least event.
//
// Idea. Every slot has a fixed path to the top, so nothing is moved and no slot stores its
// position. A group's eight ticks fill one cache line. For seven of eight new keys, the slot isn't
// its group's first before or after the change, so no further work is needed. Otherwise the group's
// least slot is found without branches. The path up is then replayed as far as the change has
// effects. If the overall winner was replaced, the whole path is replayed. In this case the
// opponents are known before the first match is over, and the processor prefetches them. Whole keys
// are read only if ticks are equal. Knuth describes only tournaments of pairs ("The Art of Computer
// Programming" 3, section 5.4.1).
//
// Invariants besides those of event_queue.h
//   1. ticks_[i] is the tick of keys_[i]. Empty slots fill up the last group.
//   2. There are groups_ groups. Node groups_ + i has the tick and slot of the least event in group
//      i. Node n, for 1 <= n < groups_, has the tick and slot of the lesser of nodes 2n and 2n + 1.
//      Hence node 1 has the least event of all, whatever the number of groups.
//   3. "Least" refers to the order of QueuedEvent, and includes empty slots.
// Memory: 36 bytes per slot. Time: setting the overall winner's key takes O(log n): 14 matches at
// 100,000 slots. Setting another slot's key takes O(1) on average, if slots are drawn evenly.
// Thread safety: see event_queue.h.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/physics/event/event_queue.h"

namespace sleight::physics {

class TournamentQueue {
 public:
  TournamentQueue() { reset(0); }
  void reset(std::uint32_t slot_count);

  void set(Slot slot, const EventKey& key) {
    const TickCount tick = key.tick.value;
    const std::uint32_t group = slot.value / k_group;
    keys_[slot.value] = key;
    ticks_[group][slot.value % k_group] = tick;
    const Node& first = nodes_[groups_ + group];
    if (tick > first.tick && first.slot != slot.value) [[likely]] {
      return;
    }
    replay(group);
  }

  void erase(Slot slot) { set(slot, k_no_event); }

  const EventKey& key_of(Slot slot) const { return keys_[slot.value]; }
  bool empty() const { return keys_[nodes_[1].slot] == k_no_event; }
  QueuedEvent least() const { return {keys_[nodes_[1].slot], Slot{nodes_[1].slot}}; }
  /// Returns the slot of the second least event, or any slot if there is none. If ticks are equal,
  /// it may be another slot, so use the result only for reading ahead.
  Slot second() const;

 private:
  static constexpr std::uint32_t k_group = 8;
  struct alignas(64) Group : std::array<TickCount, k_group> {};
  struct Node {
    TickCount tick = k_never.value;
    std::uint32_t slot = 0;
  };

  /// Returns whether slot a's event comes after slot b's event. REQUIRES: both have the same tick.
  bool loses_at_same_tick(std::uint32_t a, std::uint32_t b) const;
  /// Replaces `best` by `other` if `other` comes first.
  void meet(Node& best, const Node& other) const;
  Node least_of(std::uint32_t group) const;
  /// Updates the nodes after a change in a group.
  void replay(std::uint32_t group);

  std::vector<EventKey> keys_;  ///< by slot
  std::vector<Group> ticks_;    ///< by slot
  std::vector<Node> nodes_;     ///< node 0 is unused
  std::uint32_t groups_ = 0;
};

static_assert(EventQueue<TournamentQueue>);

}  // namespace sleight::physics
