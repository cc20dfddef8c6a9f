// Engines with other broad phases and event queues than the product's, which must give the same
// bits (worker/physics/simulator/engine.h):
//
//   SweepAndPrune   The thesis's sorted lists of extents (3.2.3); slow if bodies cluster.
//   AllPairs        A reference that compares all bodies. No engine uses it.
//   HeapQueue       A heap with four children per node.
//   CalendarQueue   Buckets of time, as the literature on event-driven dynamics recommends.
//                   In our engine, moving events between buckets costs more than moving a changed
//                   event through a few levels of another queue.
// Thread safety: pure functions.
#pragma once

#include <cstdint>

#include "worker/physics/simulator/any_engine.h"

namespace sleight::physics {

enum class BroadPhaseKind : std::uint8_t { hierarchical_grid, sweep_and_prune };
enum class QueueKind : std::uint8_t { tournament, heap, calendar };

/// Returns a value for SimulationOptions::make_engine. Null: the product's grid and tournament.
EngineMaker engine_with(BroadPhaseKind broad_phase, QueueKind queue);

}  // namespace sleight::physics
