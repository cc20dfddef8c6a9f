// Goal: queues allocate in reset alone.
// Method: this program's operator new counts; a simulation of many steps must not raise the count,
// though it makes calendars go through epochs and queues run empty and full.
#include <gtest/gtest.h>

#include "tests/unit/worker/physics/counted_allocations.h"
#include "tests/unit/worker/physics/event/queue_checks.h"
#include "worker/physics/event/calendar_queue.h"
#include "worker/physics/event/heap_queue.h"
#include "worker/physics/event/tournament_queue.h"

namespace sleight::physics {
namespace {

using counting::allocations;

template <class Queue>
class Allocations : public testing::Test {};

using Designs = testing::Types<HeapQueue, TournamentQueue, CalendarQueue>;
TYPED_TEST_SUITE(Allocations, Designs);

TYPED_TEST(Allocations, happen_in_reset_alone) {
  constexpr std::uint32_t k_slots = 200;
  Dice dice(0);
  TypeParam queue;
  const std::uint64_t at_first = allocations;
  queue.reset(k_slots);
  const std::uint64_t after_reset = allocations;
  EXPECT_GT(after_reset, at_first);
  for (int round = 0; round < 3; ++round) {
    for (std::uint32_t slot = 0; slot < k_slots; ++slot)
      queue.set(Slot{slot}, random_key(Ticks::spread, dice));
    for (int step = 0; step < 20'000 && !queue.empty(); ++step) {
      const QueuedEvent least = queue.least();
      EventKey key = least.key;
      key.tick = std::min(key.tick, k_tick_max) + dice.below(1'000'000);
      queue.set(least.slot, key);
      queue.set(Slot{dice.below(k_slots)}, key);
    }
    while (!queue.empty())
      queue.erase(queue.least().slot);
  }
  EXPECT_EQ(allocations, after_reset);
}

}  // namespace
}  // namespace sleight::physics
