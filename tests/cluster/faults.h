// A schedule of a run's faults. The seed determines the schedule before the run begins.
#pragma once

#include <cstdint>
#include <vector>

namespace sleight::cluster {

struct Fault {
  enum class Kind {
    workers_die,     ///< and return after `for_s` without their states, or never
    workers_stall,   ///< do nothing for a time, then continue unaware
    workers_join,    ///< absent before
    messages_lost,   ///< some, temporarily
    messages_twice,  ///< some, temporarily
    messages_late,   ///< some, temporarily, so later ones overtake them
    coordinator_dies,
    coordinator_stops,   ///< cleanly: waits for assignments, stores their results and ends
    dies_before_commit,  ///< before the next group's commit
    dies_in_commit,      ///< with a part of the group on disk
    dies_after_commit,
    disk_full,  ///< temporarily
  };
  Kind kind = Kind::workers_die;
  double at_s = 0;
  double for_s = 0;
  std::uint32_t first_worker = 0;
  std::uint32_t workers = 1;
  bool is_noticed = false;   ///< the coordinator is told of the loss
  bool is_for_ever = false;  ///< they never return
  double odds = 0;           ///< per message
};

inline constexpr std::uint64_t k_faults_max = 100;

/// Draws up to k_faults_max faults. Faults begin before `span_s` and last at most a fifth of
/// `span_s`.
std::vector<Fault> faults_of(std::uint64_t seed, std::uint32_t workers, double span_s);

/// Returns the time after which only permanent faults remain.
double quiet_from(const std::vector<Fault>& faults);

}  // namespace sleight::cluster
