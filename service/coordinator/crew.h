// Who computes blocks for a run: threads of this process, or these and the ranks of an MPI job.
//
// A crew carries messages and knows nothing of plans, stores or who should run what. It is driven
// by one thread (drive.h).
#pragma once

#include <cstdint>
#include <vector>

#include "common/plan/block.h"
#include "common/schema/messages.h"
#include "service/core/messages.h"

namespace sleight::coordinator {

/// What went between this process and others; nothing where there are no others.
struct Traffic {
  std::uint64_t messages = 0;  ///< in both directions
  std::uint64_t bytes = 0;
};

class Crew {
 public:
  virtual ~Crew() = default;

  /// Who is there from the beginning.
  virtual std::vector<core::Joined> members() const = 0;
  virtual void send(core::WorkerId worker, schema::Assignment assignment) = 0;
  virtual void send(core::WorkerId worker, const schema::Ping& ping) = 0;
  /// What has come in from workers; waits up to `timeout_s` for the first. A worker's failure is
  /// thrown here.
  virtual std::vector<core::Input> receive(double timeout_s) = 0;
  virtual Traffic traffic() const { return {}; }
};

}  // namespace sleight::coordinator
