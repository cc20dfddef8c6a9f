// The events that wait, and which of them is the least.
//
// Idea. A simulation has a fixed number of slots, one per body and a few for itself; a slot holds
// the earliest event of its owner, or nothing. A body whose prediction changes overwrites its slot,
// so no event that has become invalid stays behind, and the queue never grows.
//
// Invariants, of every EventQueue
//   1. least() is the least of what was set, in the order of QueuedEvent: by key, then by slot. It
//      is a function of the slots' contents alone, not of the order in which they came.
//   2. A slot is empty exactly if its key is k_no_event; so set(slot, k_no_event) empties it. A key
//      at k_never that differs from k_no_event in another field is an event like any other.
//   3. Nothing is allocated outside reset().
//   4. Any key may be set at any time. That a simulation sets no key before the tick of the event
//      that it processes may make a design fast, never right.
//
// The simulator uses TournamentQueue: the fastest at every size measured, 64 to 100,000 slots.
// Tests compare it with others (tests/engines), `sleight-bench event_queue` their speed.
// Thread safety: none is shared while one thread writes; const functions may run at once.
#pragma once

#include <compare>
#include <concepts>
#include <cstdint>

#include "common/base/ids.h"
#include "worker/physics/event/event.h"

namespace sleight::physics {

/// A place for one event.
using Slot = base::Id<struct SlotTag, std::uint32_t>;

/// The most slots of a queue: twice to four times as many numbers still fit into 32 bits.
inline constexpr std::uint32_t k_slots_max = std::uint32_t{1} << 28;

/// Ordered by key, then by slot: a total order even where two slots hold the same key, as those of
/// two bodies do that are to hit one another.
struct QueuedEvent {
  EventKey key = k_no_event;
  Slot slot{};
  friend constexpr auto operator<=>(const QueuedEvent&, const QueuedEvent&) = default;
};

/// For every slot below REQUIRES: slot.value < the slot count of the last reset.
///   reset(count)    slots 0 to count - 1, all empty; may allocate. REQUIRES: count <= k_slots_max
///   set(slot, key)  the slot holds key from now on, whatever it held before
///   erase(slot)     the slot is empty from now on, as it may have been before
///   key_of(slot)    what it holds, or k_no_event
///   empty()         whether all slots are empty, as before the first reset
///   least()         REQUIRES: not empty()
template <class Queue>
concept EventQueue = std::default_initializable<Queue> &&
    requires(Queue& queue, const Queue& unchanged, std::uint32_t count, Slot slot, EventKey key) {
  { queue.reset(count) } -> std::same_as<void>;
  { queue.set(slot, key) } -> std::same_as<void>;
  { queue.erase(slot) } -> std::same_as<void>;
  { unchanged.key_of(slot) } -> std::convertible_to<EventKey>;
  { unchanged.empty() } -> std::same_as<bool>;
  { unchanged.least() } -> std::convertible_to<QueuedEvent>;
};

}  // namespace sleight::physics
