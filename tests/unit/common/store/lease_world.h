// Simulates machines that compete for one lock on a shared disk. The clock is simulated too.
//
// The leases are real (common/store/lease.h), and the disk is in memory. Before and after every
// disk call, a process may be killed, or may pause for a moment or for several lease durations.
// Machines' clocks differ, and run up to 10% too fast or too slow. Lists of the folder may be out
// of date. A write may report failure and still take effect later. One process runs at a time, in
// an order that the seed determines.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sleight::store::testing {

/// A mistake that is planted in a simulated world. Each mistake would let two processes hold the
/// lock.
enum class Mistake {
  none,
  breaks_the_lock,       ///< the next lease's file replaces an existing file
  believes_old_lists,    ///< a process doesn't list the folder again after creating its file
  clock_stands_still,    ///< a holder's clock stops while the process pauses
  clocks_too_different,  ///< an observer's lease ends before the holder's
  takes_all_for_dead,    ///< other machines' processes are looked up on this machine
};

struct LeaseStory {
  std::uint64_t taken = 0;
  std::uint64_t taken_over = 0;  ///< from a holder that had not released it
  std::uint64_t refused = 0;
  std::uint64_t lost = 0;                  ///< leases that expired under their holder
  std::optional<std::string> violation{};  ///< when two processes could both act
};

LeaseStory simulate_leases(std::uint64_t seed, Mistake mistake = Mistake::none);

}  // namespace sleight::store::testing
