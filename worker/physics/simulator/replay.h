// How far an earlier simulation's history has been replayed, and by whom it is.
//
// Invariants, of a simulation that replays
//   1. A body is replayed if it has started and, up to the present, has done what the history says
//      in each bit: its segment and all that it knows are those of its last event there. Nothing is
//      predicted for it but its collisions with bodies that are not.
//   2. Whatever is processed that is not the history's next event, and asks for or changes what a
//      replayed body knows, makes it live first: collisions with it, decisions about rest that look
//      at it, wakes. Only its segment may be read.
//   3. What a live body rests on is live: so nobody wakes but by his own kind.
//   4. An event of the history is replayed if all of its participants are; else those that are go
//      live before it (world_replay.cpp). They go live as well before they come near a place where
//      static geometry differs, and at the history's end.
// A body goes live where it is: its state is that of the present, so nothing has to be caught up.
// Thread safety: none.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "worker/physics/simulator/history.h"
#include "worker/physics/simulator/scene_changes.h"

namespace sleight::physics {

struct Replay {
  Replay(std::shared_ptr<const History> history, SceneChanges scene_changes)
      : past(std::move(history)), changes(std::move(scene_changes)), reader(past->chunks) {}
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;

  std::shared_ptr<const History> past;
  SceneChanges changes;
  HistoryReader reader;
  /// By body: its start is to be the history's, and has not come yet.
  std::vector<std::uint8_t> awaited{};
  std::uint32_t awaited_count = 0;
  /// Nothing happens before this tick but what the history says.
  Tick quiet_until{};
};

}  // namespace sleight::physics
