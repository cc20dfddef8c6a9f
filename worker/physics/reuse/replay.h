// How far an earlier simulation's history has been replayed, and by which bodies.
//
// Invariants, of a simulation that replays
//   1. A body is replayed if it has started and, up to the present, has done what the history says
//      in each bit: its segment and all that it knows are those of its last event there. Nothing is
//      predicted for it but its collisions with bodies that are not.
//   2. An event that is not the history's next one, and reads or changes the contact state of a
//      replayed body, makes the body live first: a collision with it, a decision about rest that
//      looks at it, a wake. Only its segment may be read.
//   3. If a live body rests on a body, that one is live too; so waking never spreads to replayed
//      bodies.
//   4. An event of the history is replayed if all of its participants are replayed. Otherwise its
//      replayed participants go live before it (replaying.h). Bodies also go live before they
//      come near a place where static geometry differs, and at the history's end.
// A body goes live in its present state, so it has nothing to catch up with.
// Thread safety: none.
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
  /// By body: its start is to be the history's, and has not come yet.
  std::vector<std::uint8_t> awaited{};
  std::uint32_t awaited_count = 0;
  /// Nothing happens before this tick but what the history says.
  Tick quiet_until{};
};

}  // namespace sleight::physics
