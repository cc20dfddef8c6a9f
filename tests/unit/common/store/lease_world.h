// Machines that want one lock on a disk that they share, under a simulated clock.
//
// Real leases (common/store/lease.h) run against a disk in memory. Before and after every call of
// the disk a process may stand still, for a moment or for several leases, and be killed. Clocks of
// machines differ in what they show and run up to 10% too fast or too slow. Lists of the folder may
// be old, writes fail, and what failed may land all the same, later. One process runs at a time, in
// an order that the seed decides.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sleight::store::testing {

/// One thing that is wrong in a simulated world, of those that would let two have the lock.
enum class Mistake {
  none,
  breaks_the_lock,       ///< the next lease's file replaces one that is there
  believes_old_lists,    ///< after making its file a process doesn't look at the folder anew
  clock_stands_still,    ///< a holder's clock does not count while the process stands still
  clocks_too_different,  ///< an observer's lease is over before the holder's
  takes_all_for_dead,    ///< processes of other machines are looked for on one's own
};

struct LeaseStory {
  std::uint64_t taken = 0;
  std::uint64_t taken_over = 0;  ///< of these, from a holder that had not let go
  std::uint64_t refused = 0;
  std::uint64_t lost = 0;                  ///< leases that ended under their holder
  std::optional<std::string> violation{};  ///< two might act, and when
};

/// Some processes on some machines, for some minutes.
LeaseStory simulate_leases(std::uint64_t seed, Mistake mistake = Mistake::none);

}  // namespace sleight::store::testing
