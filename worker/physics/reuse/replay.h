// Stores how far an earlier simulation's history has been replayed, and by which bodies.
//
// Invariants of a replaying simulation
//   1. A body is replayed if it has started and has equalled its history so far, bit for bit: its
//      segment and contact state are those after its last event in the history. For a replayed
//      body, only collisions with live bodies are predicted.
//   2. If an event other than the history's next one is about to read or change a replayed body's
//      contact state, the body goes live first. Three kinds of event do this: a collision with the
//      body, a rest decision that reads its state, and waking the body. All other events read at
//      most a replayed body's segment.
//   3. If a live body rests on another body, the other body is live too; so waking never spreads to
//      replayed bodies.
//   4. An event of the history is replayed if all its participants are replayed. Otherwise the
//      replayed participants go live before the event (replaying.h). Bodies also go live before
//      they come near changed static geometry, and at the history's end.
// A body goes live in its current state, so nothing must be simulated again. Thread safety: none.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "worker/physics/reuse/history.h"
#include "worker/physics/reuse/scene_changes.h"

namespace sleight::physics {

struct Replay {
  Replay(std::shared_ptr<const History> earlier, SceneChanges scene_changes)
      : history(std::move(earlier)), changes(std::move(scene_changes)), reader(history->chunks) {}
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;

  std::shared_ptr<const History> history;
  SceneChanges changes;
  HistoryReader reader;
  /// By body: whether it hasn't started yet but will start as in the history.
  std::vector<std::uint8_t> awaited{};
  std::uint32_t awaited_count = 0;
  /// Before this tick, only the history's events happen.
  Tick quiet_until{};
};

}  // namespace sleight::physics
