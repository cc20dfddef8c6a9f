// A crew computes a run's blocks. Members are threads of this process and, in an MPI job, the other
// ranks.
//
// A crew only carries messages. A crew has no plan, no store and no scheduler. One thread drives
// it.
#pragma once

#include <cstdint>
#include <vector>

#include "common/schema/messages.h"
#include "service/core/messages.h"

namespace sleight::coordinator {

/// Counts messages between this process and others. Zero without other processes.
struct Traffic {
  std::uint64_t messages = 0;  ///< in both directions
  std::uint64_t bytes = 0;
};

class Crew {
 public:
  virtual ~Crew() = default;

  /// Returns the members that exist at the beginning.
  virtual std::vector<core::Joined> members() const = 0;
  virtual void send(core::WorkerId worker, schema::Assignment assignment) = 0;
  virtual void send(core::WorkerId worker, const schema::Ping& ping) = 0;
  /// Returns the workers' input; waits up to `timeout_s`. Rethrows a worker's exception.
  virtual std::vector<core::Input> receive(double timeout_s) = 0;
  virtual Traffic traffic() const { return {}; }
};

}  // namespace sleight::coordinator
