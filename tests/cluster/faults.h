// What goes wrong in a run, and when: a schedule drawn from the seed before the run begins.
#pragma once

#include <cstdint>
#include <vector>

namespace sleight::cluster {

struct Fault {
  enum class Kind {
    workers_die,     ///< and come back after `for_s`, knowing nothing; or never
    workers_stall,   ///< do nothing for a time, and go on as if nothing had been
    workers_join,    ///< these are not there before
    messages_lost,   ///< some of them, for a time
    messages_twice,  ///< likewise
    messages_late,   ///< likewise: later ones overtake them
    coordinator_dies,
    coordinator_stops,   ///< in order: it waits for what is given out, stores it and leaves
    dies_before_commit,  ///< of the next group
    dies_in_commit,      ///< when a part of what was put is on disk
    dies_after_commit,
    disk_full,  ///< for a time
  };
  Kind kind = Kind::workers_die;
  double at_s = 0;
  double for_s = 0;
  std::uint32_t first_worker = 0;
  std::uint32_t workers = 1;
  bool is_noticed = false;   ///< the coordinator is told that they are gone
  bool is_for_ever = false;  ///< they don't come back
  double odds = 0;           ///< of a message
};

inline constexpr std::uint64_t k_faults_max = 100;

/// Up to k_faults_max, the last begun before `span_s`, none longer than a fifth of that.
std::vector<Fault> faults_of(std::uint64_t seed, std::uint32_t workers, double span_s);

/// When all that doesn't last for ever is over.
double quiet_from(const std::vector<Fault>& faults);

}  // namespace sleight::cluster
