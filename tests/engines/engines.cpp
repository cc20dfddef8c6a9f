#include "tests/engines/engines.h"

#include <utility>

#include "tests/engines/calendar_queue.h"
#include "tests/engines/heap_queue.h"
#include "tests/engines/sweep_and_prune.h"
#include "worker/physics/broad_phase/hierarchical_grid.h"
#include "worker/physics/event/tournament_queue.h"
#include "worker/physics/simulator/engine_impl.h"

namespace sleight::physics {
namespace {

template <class Boxes, class Queue>
std::unique_ptr<AnyEngine> make(World& world, Replaying& replaying, EngineOptions options,
                                const std::optional<Takeover>& from) {
  return std::make_unique<Engine<Boxes, Queue>>(world, replaying, std::move(options), from);
}

}  // namespace

EngineMaker engine_with(BroadPhaseKind broad_phase, QueueKind queue) {
  const bool sweeps = broad_phase == BroadPhaseKind::sweep_and_prune;
  switch (queue) {
    case QueueKind::tournament:
      return sweeps ? make<SweepAndPrune, TournamentQueue> : nullptr;
    case QueueKind::heap:
      return sweeps ? make<SweepAndPrune, HeapQueue> : make<HierarchicalGrid, HeapQueue>;
    case QueueKind::calendar:
      break;
  }
  return sweeps ? make<SweepAndPrune, CalendarQueue> : make<HierarchicalGrid, CalendarQueue>;
}

}  // namespace sleight::physics
