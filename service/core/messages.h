// What goes into the scheduler and what comes out of it. All of it is logical: who said what about
// which assignment. Where bytes travel and what is written where is the coordinator's.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "common/base/ids.h"
#include "common/plan/block.h"
#include "common/schema/messages.h"

namespace sleight::core {

/// A process that computes blocks, with one thread or more.
using WorkerId = base::Id<struct WorkerTag, std::uint32_t>;

/// A worker is there. In another incarnation than before it knows nothing of what it was given.
struct Joined {
  WorkerId worker;
  std::uint64_t incarnation = 0;
  std::uint32_t threads = 1;
};
/// It is known to be gone.
struct Left {
  WorkerId worker;
};
/// It has run an assignment, or says that it can't without a state.
struct Delivered {
  WorkerId worker;
  schema::Delivery delivery;
};
/// It says what it has before it.
struct Answered {
  WorkerId worker;
  schema::Pong pong;
};
/// Time has come to here, by a clock that begins anywhere and doesn't go back.
struct Tick {
  double now_s = 0;
};
/// Nothing more shall be handed out.
struct StopAsked {};

using Input = std::variant<Joined, Left, Delivered, Answered, Tick, StopAsked>;

/// Send it.
struct Assign {
  WorkerId worker;
  schema::Assignment assignment;
};
/// Ask what it has before it: nothing was heard of it for too long.
struct Ask {
  WorkerId worker;
  schema::Ping ping;
};
/// Store these: they are results of the run.
struct Keep {
  std::vector<plan::UnitResult> results;
};

using Effect = std::variant<Assign, Ask, Keep>;

}  // namespace sleight::core
