// Times of event queues under the load of a gas of hard spheres. A step removes the earliest event.
// The step schedules new events for the event's body and another body, after exponential waits. The
// step also slightly moves the events of six more bodies.
//
// Bodies are drawn uniformly, which is the worst case for caches. In a simulation, neighbours tend
// to be close in memory, and many of the six bodies would keep their event.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/math/elementary.h"
#include "common/random/distributions.h"
#include "tests/bench/harness.h"
#include "tests/engines/calendar_queue.h"
#include "tests/engines/heap_queue.h"
#include "worker/physics/event/tournament_queue.h"

namespace sleight::bench {
namespace {

using physics::EventKey;
using physics::EventKind;
using physics::EventQueue;
using physics::QueuedEvent;
using physics::Slot;
using physics::Tick;
using physics::TickCount;

/// Mean time between two events of a body.
constexpr double k_mean_wait_ticks = 0.1 * physics::k_ticks_per_second;
constexpr std::size_t k_changed = 6;

/// Random choices of a step, drawn in advance so that only the queue is timed.
struct Step {
  std::array<TickCount, 2> waits{};
  std::array<std::int32_t, k_changed> shifts{};
  std::uint32_t partner = 0;
  std::array<std::uint32_t, k_changed> changed{};
};

std::vector<Step> drawn_steps(std::uint32_t slots) {
  random::Stream stream({.seed = 1, .purpose = random::Purpose::prior}, slots);
  constexpr double k_rate = 1 / k_mean_wait_ticks;
  const random::Uniform shift{.low = -0.01 * k_mean_wait_ticks, .high = 0.01 * k_mean_wait_ticks};
  const random::UniformInteger slot{.count = slots};
  std::vector<Step> steps(std::size_t{1} << 15);
  for (Step& step : steps) {
    for (TickCount& ticks : step.waits)
      ticks = static_cast<TickCount>(-math::log(stream.uniform()) / k_rate) + 1;
    for (std::int32_t& ticks : step.shifts)
      ticks = static_cast<std::int32_t>(shift.draw(stream));
    step.partner = static_cast<std::uint32_t>(slot.draw(stream));
    for (std::uint32_t& changed : step.changed)
      changed = static_cast<std::uint32_t>(slot.draw(stream));
  }
  return steps;
}

template <EventQueue Queue>
class Gas {
 public:
  explicit Gas(std::uint32_t slots) : steps_(drawn_steps(slots)) {
    queue_.reset(slots);
    for (std::uint32_t slot = 0; slot < slots; ++slot)
      queue_.set(Slot{slot}, collision(Tick{steps_[slot % steps_.size()].waits[0] + slot}, slot));
  }

  QueuedEvent step() {
    const QueuedEvent least = queue_.least();
    const Tick now = least.key.tick;
    const Step& step = steps_[next_++ % steps_.size()];
    queue_.set(least.slot, collision(now + step.waits[0], least.slot.value));
    queue_.set(Slot{step.partner}, collision(now + step.waits[1], step.partner));
    for (std::size_t i = 0; i < k_changed; ++i) {
      const Slot slot{step.changed[i]};
      const Tick moved = queue_.key_of(slot).tick + step.shifts[i];
      queue_.set(slot, collision(std::max(moved, now), slot.value));
    }
    return least;
  }

 private:
  static EventKey collision(Tick tick, std::uint32_t body) {
    return {.tick = tick, .kind = EventKind::collision, .lower = body};
  }

  std::vector<Step> steps_;
  Queue queue_;
  std::size_t next_ = 0;
};

/// Hash of the first events. All queues have the same hash.
std::uint64_t expected_hash(std::uint32_t slots) {
  switch (slots) {
    case 64:
      return 0xa6f4c15d28ce1cc1U;
    case 1000:
      return 0xbfa9deb113af12b1U;
    case 10648:
      return 0x34871d2cab80da03U;
    default:
      return 0x9a5f1fce2eff54acU;
  }
}

template <EventQueue Queue>
void event_queue(benchmark::State& state) {
  const auto slots = static_cast<std::uint32_t>(state.range(0));
  Gas<Queue> gas(slots);
  ResultHash hash;
  for (int i = 0; i < 50'000; ++i) {
    const QueuedEvent least = gas.step();
    hash.add(static_cast<std::uint64_t>(least.key.tick.value));
    hash.add(std::uint64_t{least.slot.value});
  }
  for (auto _ : state)
    benchmark::DoNotOptimize(gas.step());
  state.SetItemsProcessed(state.iterations());
  verify(state, hash.value(), expected_hash(slots));
}

void sizes(benchmark::internal::Benchmark* registered) {
  for (const int slots : {64, 1000, 10648, 100000})
    registered->Arg(slots);
}
BENCHMARK(event_queue<physics::TournamentQueue>)->Name("event_queue/tournament")->Apply(sizes);
BENCHMARK(event_queue<physics::HeapQueue>)->Name("event_queue/heap")->Apply(sizes);
BENCHMARK(event_queue<physics::CalendarQueue>)->Name("event_queue/calendar")->Apply(sizes);

}  // namespace
}  // namespace sleight::bench
