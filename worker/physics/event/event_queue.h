// A queue of waiting events. It returns the least event.
//
// Idea. A simulation has a fixed number of slots: one per body, and a few for the simulation
// itself. A slot contains its owner's earliest event, or nothing. If a body's prediction changes,
// the body overwrites its slot. So the queue contains no invalid events, and never grows.
//
// Invariants of every EventQueue
//   1. least() is the least event in the order of QueuedEvent: by key, then by slot. The result
//      depends only on the slots' contents, not on the order of calls.
//   2. A slot is empty exactly if its key is k_no_event, so set(slot, k_no_event) empties it. A key
//      with tick k_never is an ordinary event unless it is k_no_event.
//   3. Nothing is allocated outside reset().
//   4. Any key may be set at any time. A queue may be optimised for keys that are not before the
//      current event's tick, but it must be correct for all keys.
//
// The simulator uses TournamentQueue, the fastest queue at all measured sizes (64 to 100,000
// slots). Tests compare TournamentQueue with other queues (tests/engines), and `sleight-bench
// event_queue` compares speeds. Thread safety: const functions may run concurrently, but not while
// a thread writes.
#pragma once

#include <compare>
#include <concepts>
#include <cstdint>

#include "common/base/ids.h"
#include "worker/physics/event/event.h"

namespace sleight::physics {

/// A place for one event.
using Slot = base::Id<struct SlotTag, std::uint32_t>;

/// Maximum number of slots of a queue. Even two to four times this number fits into 32 bits.
inline constexpr std::uint32_t k_slots_max = std::uint32_t{1} << 28;

/// Ordered by key, then by slot. If two bodies will collide, their slots have the same key. So the
/// order includes the slot.
struct QueuedEvent {
  EventKey key = k_no_event;
  Slot slot{};
  friend constexpr auto operator<=>(const QueuedEvent&, const QueuedEvent&) = default;
};

/// All functions with a slot REQUIRE: slot.value < the slot count of the last reset.
template <class Queue>
concept EventQueue = std::default_initializable<Queue> &&
    requires(Queue& queue, const Queue& unchanged, std::uint32_t count, Slot slot, EventKey key) {
  // Creates empty slots 0 to count - 1; may allocate. REQUIRES: count <= k_slots_max.
  { queue.reset(count) } -> std::same_as<void>;
  { queue.set(slot, key) } -> std::same_as<void>;
  { queue.erase(slot) } -> std::same_as<void>;
  // Returns the slot's key, or k_no_event.
  { unchanged.key_of(slot) } -> std::convertible_to<EventKey>;
  // Returns whether all slots are empty. Before the first reset, returns true.
  { unchanged.empty() } -> std::same_as<bool>;
  // REQUIRES: not empty().
  { unchanged.least() } -> std::convertible_to<QueuedEvent>;
};

}  // namespace sleight::physics
