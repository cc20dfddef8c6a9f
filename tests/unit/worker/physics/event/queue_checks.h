// Checks for every queue. Each check compares a queue's answers with SlowQueue's answers.
//
// A check returns the first difference as text, or nothing. So a test can also expect a faulty
// queue to differ.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "common/random/stream.h"
#include "tests/unit/worker/physics/event/slow_queue.h"

namespace sleight::physics {

inline std::string printed(const EventKey& key) {
  return fmt::format("({}, {}, {}, {}, {})", key.tick.value, static_cast<int>(key.kind), key.lower,
                     key.higher, key.feature);
}

/// A queue and the reference, side by side. `difference` is the first difference found.
template <EventQueue Queue>
class Pair {
 public:
  void reset(std::uint32_t slots) {
    queue_.reset(slots);
    reference_.reset(slots);
    slots_ = slots;
    for (std::uint32_t slot = 0; slot < slots; ++slot)
      compare_slot(Slot{slot});
    compare();
  }
  void set(Slot slot, const EventKey& key) {
    queue_.set(slot, key);
    reference_.set(slot, key);
    compare_slot(slot);
    compare();
  }
  void erase(Slot slot) {
    queue_.erase(slot);
    reference_.erase(slot);
    compare_slot(slot);
    compare();
  }

  void compare() {
    ++operations_;
    if (queue_.empty() != reference_.empty()) {
      note(fmt::format("empty() is {}", queue_.empty()));
    } else if (!queue_.empty()) {
      const QueuedEvent got = queue_.least();
      const QueuedEvent right = reference_.least();
      if (got == right) return;
      note(fmt::format("least() is {} in slot {}, not {} in slot {}", printed(got.key), got.slot,
                       printed(right.key), right.slot));
    }
  }
  void compare_slot(Slot slot) {
    const EventKey got = queue_.key_of(slot);
    const EventKey right = reference_.key_of(slot);
    if (got == right) return;
    note(fmt::format("key_of({}) is {}, not {}", slot, printed(got), printed(right)));
  }

  std::uint32_t slots() const { return slots_; }
  const SlowQueue& reference() const { return reference_; }
  const std::string& difference() const { return difference_; }
  std::uint64_t operations() const { return operations_; }

 private:
  void note(const std::string& text) {
    if (!difference_.empty()) return;
    difference_ = fmt::format("{} slots, operation {}: {}", slots_, operations_, text);
  }

  Queue queue_;
  SlowQueue reference_;
  std::uint32_t slots_ = 0;
  std::uint64_t operations_ = 0;
  std::string difference_;
};

class Dice {
 public:
  explicit Dice(std::uint64_t index)
      : stream_({.seed = 141421, .purpose = random::Purpose::prior}, index) {}
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>(random::UniformInteger{.count = count}.draw(stream_));
  }
  bool once_in(std::uint32_t count) { return below(count) == 0; }
  std::uint64_t bits() { return stream_.bits(); }

 private:
  random::Stream stream_;
};

enum class Ticks : std::uint8_t { few, spread, extreme };

inline Tick random_tick(Ticks ticks, Dice& dice) {
  switch (ticks) {
    case Ticks::few:
      return Tick{dice.below(4)};
    case Ticks::spread:
      return Tick{static_cast<TickCount>(dice.bits() >> (20 + dice.below(40)))};
    default: {
      const std::array<Tick, 8> some = {k_never,
                                        k_never - 1,
                                        k_tick_max,
                                        Tick{0},
                                        Tick{-1},
                                        Tick{std::numeric_limits<TickCount>::min()},
                                        Tick{TickCount{1} << 62},
                                        Tick{-(TickCount{1} << 62)}};
      return some[dice.below(some.size())];
    }
  }
}

inline EventKey random_key(Ticks ticks, Dice& dice) {
  if (dice.once_in(100)) return k_no_event;
  EventKey key{.tick = random_tick(ticks, dice),
               .kind = static_cast<EventKind>(dice.below(7)),
               .lower = dice.below(3),
               .higher = dice.below(3),
               .feature = dice.below(2)};
  if (dice.once_in(10)) key = {.tick = key.tick, .kind = EventKind::sample, .lower = UINT32_MAX};
  return key;
}

/// Sets and erases any slots at any time. Many keys have equal ticks; some are equal in all fields.
template <EventQueue Queue>
std::string check_random_operations(std::uint32_t slots, Ticks ticks, std::uint32_t operations,
                                    Dice& dice) {
  Pair<Queue> pair;
  pair.reset(slots);
  // The queue's size drifts between nearly empty and full.
  std::uint32_t erased_in_8 = 0;
  for (std::uint32_t i = 0; i < operations && pair.difference().empty(); ++i) {
    if (dice.once_in(200)) erased_in_8 = dice.below(8);
    const Slot slot{dice.below(slots)};
    const bool of_least = dice.once_in(4) && !pair.reference().empty();
    const Slot chosen = of_least ? pair.reference().least().slot : slot;
    if (dice.below(8) < erased_in_8) {
      pair.erase(chosen);
    } else {
      EventKey key = random_key(ticks, dice);
      if (dice.once_in(8)) key = pair.reference().key_of(slot);  // sets the slot's own key again
      pair.set(chosen, key);
    }
  }
  for (std::uint32_t slot = 0; slot < slots; ++slot)
    pair.compare_slot(Slot{slot});
  return pair.difference();
}

/// Sets keys as a simulation does: never before the least event. The mean wait is
/// `mean_wait_ticks`, but some bodies wait thousands of times longer. Now and then, bodies fall
/// asleep or wake.
template <EventQueue Queue>
std::string check_simulation(std::uint32_t slots, std::uint32_t mean_wait_ticks,
                             std::uint32_t steps, Dice& dice) {
  Pair<Queue> pair;
  pair.reset(slots);
  const auto later = [&](Tick now, std::uint32_t body) {
    const TickCount wait = dice.below(2 * mean_wait_ticks + 1);
    return EventKey{.tick = now + (dice.once_in(30) ? 5000 * wait : wait),
                    .kind = static_cast<EventKind>(dice.below(7)),
                    .lower = body};
  };
  for (std::uint32_t slot = 0; slot < slots; ++slot)
    pair.set(Slot{slot}, later(Tick{0}, slot));

  for (std::uint32_t step = 0; step < steps && pair.difference().empty(); ++step) {
    if (pair.reference().empty()) pair.set(Slot{0}, later(Tick{0}, 0));
    const QueuedEvent least = pair.reference().least();
    const Tick now = least.key.tick;
    if (dice.once_in(50)) {
      pair.erase(least.slot);
    } else {
      pair.set(least.slot, later(now, least.slot.value));
    }
    pair.set(Slot{dice.below(slots)}, later(now, least.slot.value));
    for (std::uint32_t i = dice.below(8); i > 0; --i) {
      const Slot slot{dice.below(slots)};
      EventKey key = pair.reference().key_of(slot);
      if (key == k_no_event) continue;
      const TickCount shift =
          TickCount{dice.below(mean_wait_ticks / 50 + 2)} - TickCount{mean_wait_ticks / 100};
      key.tick = std::max(key.tick + shift, now);
      pair.set(slot, key);
    }
  }
  return pair.difference();
}

}  // namespace sleight::physics
