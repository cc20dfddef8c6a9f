// Events on their way into the run store, and how far a run's events are told.
//
// Thread safety: values.
#pragma once

#include <cstdint>
#include <vector>

#include "common/events/run_event.h"

namespace sleight::store {

/// Up to which results a run's events are told, and how many were: what comes next follows from it
/// (service/coordinator/event_sequence.h).
struct ToldFrontier {
  std::uint64_t scans = 0;      ///< of all chains
  std::uint64_t starts = 0;     ///< of the search
  std::uint64_t solutions = 0;  ///< events of each kind
  std::uint64_t finds = 0;
  std::uint64_t failures = 0;
  bool operator==(const ToldFrontier&) const = default;
};

/// Events without numbers, which they get when they are committed.
struct PutEvents {
  std::vector<events::RunEvent> events;
  ToldFrontier reached;  ///< with these
};

}  // namespace sleight::store
