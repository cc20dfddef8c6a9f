#include "tests/cluster/faults.h"

#include <algorithm>

#include "tests/cluster/dice.h"

namespace sleight::cluster {
namespace {

using Kind = Fault::Kind;

/// Workers and messages fail more often than the coordinator, because the coordinator's end
/// disturbs everything.
constexpr Kind k_kinds[] = {
    Kind::workers_die,       Kind::workers_die,    Kind::workers_die,
    Kind::workers_stall,     Kind::workers_stall,  Kind::workers_stall,
    Kind::workers_join,      Kind::workers_join,   Kind::messages_lost,
    Kind::messages_lost,     Kind::messages_lost,  Kind::messages_twice,
    Kind::messages_twice,    Kind::messages_twice, Kind::messages_late,
    Kind::messages_late,     Kind::messages_late,  Kind::coordinator_dies,
    Kind::coordinator_stops, Kind::dies_in_commit, Kind::dies_before_commit,
    Kind::dies_after_commit, Kind::disk_full,
};

}  // namespace

std::vector<Fault> faults_of(std::uint64_t seed, std::uint32_t workers, double span_s) {
  Dice dice(seed, Dice::Part::faults);
  std::vector<Fault> faults(dice.whole(0, k_faults_max));
  for (Fault& fault : faults) {
    fault.kind = k_kinds[dice.whole(0, std::size(k_kinds) - 1)];
    fault.at_s = dice.uniform(0, span_s);
    fault.for_s = span_s * dice.log_uniform(0.002, 0.2);
    // A host has several workers; a rack has several hosts.
    const double most = std::max(1.0, workers / 4.0);
    fault.workers = static_cast<std::uint32_t>(dice.log_uniform(1, most));
    fault.first_worker = static_cast<std::uint32_t>(dice.whole(0, workers - fault.workers));
    fault.is_noticed = dice.chance(0.3);
    fault.is_for_ever = dice.chance(0.2);
    fault.odds = dice.log_uniform(0.01, 0.8);
  }
  std::ranges::stable_sort(faults, {}, &Fault::at_s);
  return faults;
}

double quiet_from(const std::vector<Fault>& faults) {
  double end_s = 0;
  for (const Fault& fault : faults)
    end_s = std::max(end_s, fault.at_s + fault.for_s);
  return end_s;
}

}  // namespace sleight::cluster
