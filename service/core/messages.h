// Inputs and effects of the scheduler, which the coordinator transports and stores.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "common/base/ids.h"
#include "common/schema/messages.h"

namespace sleight::core {

/// A process that computes blocks. It has at least one thread.
using WorkerId = base::Id<struct WorkerTag, std::uint32_t>;

/// A worker has joined. In a new incarnation the worker has lost its earlier assignments.
struct Joined {
  WorkerId worker;
  std::uint64_t incarnation = 0;
  std::uint32_t threads = 1;
};
/// A worker is known to be gone.
struct Left {
  WorkerId worker;
};
/// A worker has run an assignment or reports that it lacks a state.
struct Delivered {
  WorkerId worker;
  schema::Delivery delivery;
};
/// A worker lists its assignments.
struct Answered {
  WorkerId worker;
  schema::Pong pong;
};
/// The time on a monotonic clock with any origin.
struct Tick {
  double now_s = 0;
};
/// A request to hand out no more work.
struct StopAsked {};

using Input = std::variant<Joined, Left, Delivered, Answered, Tick, StopAsked>;

/// Send this assignment.
struct Assign {
  WorkerId worker;
  schema::Assignment assignment;
};
/// Ask a worker for its assignments. The worker has been silent for too long.
struct Ask {
  WorkerId worker;
  schema::Ping ping;
};
/// Store these results of the run.
struct Keep {
  std::vector<plan::UnitResult> results;
};

using Effect = std::variant<Assign, Ask, Keep>;

}  // namespace sleight::core
