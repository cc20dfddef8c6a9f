// Goal: every event queue returns the same answers as the slow reference. Method: run random
// operations on three sets of ticks: few different ticks, widely spread ticks and extreme ticks.
// Also run operations like a simulation's operations, and some edge cases. The suite must reject
// queues with one deliberate mistake each.
#include "worker/physics/event/event_queue.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/engines/calendar_queue.h"
#include "tests/engines/heap_queue.h"
#include "tests/support/property.h"
#include "tests/unit/worker/physics/event/queue_checks.h"
#include "tests/unit/worker/physics/event/slow_queue.h"
#include "worker/physics/event/tournament_queue.h"

namespace sleight::physics {
namespace {

template <class Queue>
class EventQueues : public testing::Test {};

using Designs = testing::Types<SlowQueue, HeapQueue, TournamentQueue, CalendarQueue>;
TYPED_TEST_SUITE(EventQueues, Designs);

constexpr EventKey at(TickCount tick, std::uint32_t lower = 0) {
  return {.tick = Tick{tick}, .kind = EventKind::collision, .lower = lower};
}

TYPED_TEST(EventQueues, agree_with_the_reference_on_random_operations) {
  // The test runs 70 * 3 * 8000 + 3 * 5000 = 1.7 million operations. In deploy/test, it runs a
  // quarter of these.
  const auto operations = static_cast<std::uint32_t>(property::of_tier(2'000, 8'000));
  for (std::uint32_t slots = 1; slots <= 70; ++slots) {
    for (const Ticks ticks : {Ticks::few, Ticks::spread, Ticks::extreme}) {
      Dice dice(slots);
      EXPECT_EQ(check_random_operations<TypeParam>(slots, ticks, operations, dice), "");
    }
  }
  for (const Ticks ticks : {Ticks::few, Ticks::spread, Ticks::extreme}) {
    Dice dice(1000);
    EXPECT_EQ(check_random_operations<TypeParam>(1000, ticks, 5'000, dice), "");
  }
}

TYPED_TEST(EventQueues, agree_with_the_reference_in_a_simulation) {
  for (const std::uint32_t slots : {1U, 2U, 7U, 9U, 64U, 130U, 600U}) {
    for (const std::uint32_t mean_wait_ticks : {2U, 1000U, 100'000'000U}) {
      Dice dice(slots);
      EXPECT_EQ(check_simulation<TypeParam>(slots, mean_wait_ticks, 4'000, dice), "");
    }
  }
}

TYPED_TEST(EventQueues, hold_nothing_at_first_and_after_a_reset) {
  // Goal: reset() empties a full queue, even if it changes the number of slots.
  TypeParam queue;
  EXPECT_TRUE(queue.empty());
  queue.reset(0);
  EXPECT_TRUE(queue.empty());
  for (const std::uint32_t slots : {70U, 1U, 70U, 8U, 9U, 300U}) {
    queue.reset(slots);
    EXPECT_TRUE(queue.empty());
    for (std::uint32_t slot = 0; slot < slots; ++slot) {
      EXPECT_EQ(queue.key_of(Slot{slot}), k_no_event);
      queue.erase(Slot{slot});
      EXPECT_TRUE(queue.empty());
    }
    for (std::uint32_t slot = 0; slot < slots; ++slot)
      queue.set(Slot{slot}, at(1000 - slot));
    EXPECT_EQ(queue.least(), (QueuedEvent{at(1001 - slots), Slot{slots - 1}}));
  }
}

TYPED_TEST(EventQueues, equal_keys_go_by_slot_and_equal_ticks_by_key) {
  // Goal: events at one tick are ordered by key, and events with equal keys by slot. Method: set
  // the same events in ascending and in descending order of slots.
  TypeParam queue;
  for (const bool backwards : {false, true}) {
    queue.reset(20);
    for (std::uint32_t i = 0; i < 20; ++i)
      queue.set(Slot{backwards ? 19 - i : i}, at(4, 1));
    queue.set(Slot{11}, at(4, 0));
    EXPECT_EQ(queue.least(), (QueuedEvent{at(4, 0), Slot{11}}));
    queue.set(Slot{11}, at(4, 2));
    for (std::uint32_t slot = 0; slot < 20; ++slot) {
      if (slot == 11) continue;
      EXPECT_EQ(queue.least(), (QueuedEvent{at(4, 1), Slot{slot}}));
      queue.erase(Slot{slot});
    }
    EXPECT_EQ(queue.least(), (QueuedEvent{at(4, 2), Slot{11}}));
  }
}

TYPED_TEST(EventQueues, what_never_happens_is_still_in_order) {
  // Goal: the queue orders keys at k_never like other events, but treats k_no_event as no event.
  // Method: set all slots to keys at k_never.
  TypeParam queue;
  queue.reset(30);
  EventKey never = k_no_event;
  for (std::uint32_t slot = 0; slot < 30; ++slot) {
    never.lower = slot / 2 + 7;
    queue.set(Slot{29 - slot}, never);
  }
  never.lower = 7;
  EXPECT_EQ(queue.least(), (QueuedEvent{never, Slot{28}}));
  queue.set(Slot{28}, k_no_event);
  EXPECT_EQ(queue.least(), (QueuedEvent{never, Slot{29}}));
  EXPECT_EQ(queue.key_of(Slot{28}), k_no_event);
  queue.set(Slot{3}, at(k_never.value - 1));
  EXPECT_EQ(queue.least(), (QueuedEvent{at(k_never.value - 1), Slot{3}}));
  for (std::uint32_t slot = 0; slot < 30; ++slot)
    queue.set(Slot{slot}, k_no_event);
  EXPECT_TRUE(queue.empty());
}

TEST(Tournament, TheSecondIsTheLeastOfTheOthers) {
  // Goal: second() ignores the first event's slot and returns the slot of the least event in the
  // others. Method: compare the slot with the result of a scan of all slots.
  Dice dice(5);
  for (const std::uint32_t slots : {2U, 8U, 9U, 100U, 1001U}) {
    TournamentQueue queue;
    queue.reset(slots);
    for (std::uint32_t slot = 0; slot < slots; ++slot)
      queue.set({slot}, at(TickCount{dice.below(1U << 20U)} * slots + slot));
    for (int i = 0; i < 1000; ++i) {
      const Slot first = queue.least().slot;
      Slot second{first.value == 0 ? 1U : 0U};
      for (std::uint32_t slot = 0; slot < slots; ++slot) {
        if (slot != first.value && queue.key_of({slot}) < queue.key_of(second)) second = {slot};
      }
      ASSERT_EQ(queue.second().value, second.value) << slots;
      queue.set(first, at(TickCount{dice.below(1U << 20U)} * slots + first.value));
    }
  }
  TournamentQueue one;
  one.reset(1);
  one.set({0}, at(7));
  EXPECT_EQ(one.key_of(one.second()), at(7)) << "some slot, where there is no other";
}

enum class Mistake : std::uint8_t {
  by_insertion,
  tick_alone,
  slot_backwards,
  forgets_erase,
  drops
};

template <Mistake mistake>
class WrongQueue {
 public:
  void reset(std::uint32_t slot_count) {
    keys_.assign(slot_count, k_no_event);
    turns_.assign(slot_count, 0);
  }
  void set(Slot slot, const EventKey& key) {
    turns_[slot.value] = ++turn_;
    if (mistake == Mistake::drops && turn_ % 500 == 0) return;
    keys_[slot.value] = key;
  }
  void erase(Slot slot) {
    if (mistake == Mistake::forgets_erase && slot.value == 7) return;
    keys_[slot.value] = k_no_event;
  }
  EventKey key_of(Slot slot) const { return keys_[slot.value]; }
  bool empty() const { return std::ranges::count(keys_, k_no_event) == std::ssize(keys_); }
  QueuedEvent least() const {
    std::uint32_t least = 0;
    for (std::uint32_t slot = 1; slot < keys_.size(); ++slot) {
      if (precedes(slot, least)) least = slot;
    }
    return {keys_[least], Slot{least}};
  }

 private:
  bool precedes(std::uint32_t a, std::uint32_t b) const {
    if (mistake == Mistake::tick_alone) return keys_[a].tick < keys_[b].tick;
    if (keys_[a] != keys_[b]) return keys_[a] < keys_[b];
    if (mistake == Mistake::by_insertion) return turns_[a] < turns_[b];
    return mistake == Mistake::slot_backwards ? a > b : a < b;
  }

  std::vector<EventKey> keys_;
  std::vector<std::uint64_t> turns_;
  std::uint64_t turn_ = 0;
};

template <class Queue>
bool passes() {
  for (const std::uint32_t slots : {1U, 2U, 9U, 64U}) {
    for (const Ticks ticks : {Ticks::few, Ticks::spread, Ticks::extreme}) {
      Dice dice(slots);
      if (!check_random_operations<Queue>(slots, ticks, 5'000, dice).empty()) return false;
    }
  }
  return true;
}

TEST(QueueChecks, notice_each_mistake) {
  // Goal: the random operations accept a correct queue and reject each queue with a deliberate
  // mistake.
  EXPECT_TRUE(passes<SlowQueue>());
  EXPECT_FALSE(passes<WrongQueue<Mistake::by_insertion>>());
  EXPECT_FALSE(passes<WrongQueue<Mistake::tick_alone>>());
  EXPECT_FALSE(passes<WrongQueue<Mistake::slot_backwards>>());
  EXPECT_FALSE(passes<WrongQueue<Mistake::forgets_erase>>());
  EXPECT_FALSE(passes<WrongQueue<Mistake::drops>>());
}

TEST(QueueChecks, notice_ties_in_a_simulation) {
  // Goal: check_simulation() rejects a queue that orders events by tick alone. Method: use a mean
  // wait of 2 ticks, so that several events share a tick.
  Dice dice(0);
  EXPECT_NE(check_simulation<WrongQueue<Mistake::tick_alone>>(64, 2, 1'500, dice), "");
}

}  // namespace
}  // namespace sleight::physics
