// Who computes units: threads of this process, or these and the ranks of an MPI job.
//
// An executor knows nothing of plans or stores. It is driven by one thread (drive.h).
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/bytes.h"
#include "common/plan/unit.h"

namespace sleight::coordinator {

class Executor {
 public:
  virtual ~Executor() = default;

  /// How many units may be submitted now without waiting behind others for long.
  virtual std::size_t room() const = 0;
  virtual void submit(const plan::Unit& unit, base::Bytes state) = 0;
  /// Results that have come in; waits up to `timeout_s` for the first. A worker's failure is
  /// thrown here.
  virtual std::vector<plan::UnitResult> wait(double timeout_s) = 0;
  /// Forgets units that nobody has begun, where that can be told.
  virtual void drop_waiting() = 0;
  /// Units submitted whose results have not been returned.
  virtual std::size_t outstanding() const = 0;
  /// How many units are computed at once, for progress lines.
  virtual std::size_t workers() const = 0;
};

}  // namespace sleight::coordinator
