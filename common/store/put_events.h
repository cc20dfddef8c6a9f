// Events that are put into the run store, and the progress of event numbering.
//
// Thread safety: values.
#pragma once

#include <cstdint>
#include <vector>

#include "common/events/run_event.h"

namespace sleight::store {

/// Says for which results events have been created, and how many events. The next events follow
/// from this frontier (service/coordinator/event_sequence.h).
struct ToldFrontier {
  std::uint64_t scans = 0;      ///< of all chains
  std::uint64_t starts = 0;     ///< of the search
  std::uint64_t solutions = 0;  ///< events of each kind
  std::uint64_t finds = 0;
  std::uint64_t failures = 0;
  bool operator==(const ToldFrontier&) const = default;
};

/// Events without numbers. The commit assigns the numbers.
struct PutEvents {
  std::vector<events::RunEvent> events;
  ToldFrontier reached;  ///< including these events
};

}  // namespace sleight::store
