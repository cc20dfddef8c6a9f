// Mistakes made by workers, and mistakes in messages between a plan and its executor.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "tests/statistical/mutants/mutant.h"

namespace sleight::statistical {
namespace {

using plan::Unit;
using plan::UnitResult;
using plan::UnitWorker;

/// Runs the unit `other` with the real worker, and reports its result as the result of `unit`.
UnitResult run_other(const UnitWorker& right, const Unit& unit, const Unit& other,
                     base::BytesView state) {
  UnitResult result = right.run(other, state);
  result.unit = unit;
  for (plan::ScanRecord& record : result.scans)
    record.inverse_temperature = unit.inverse_temperature(0);
  return result;
}

std::function<Run()> instead(void (*change)(Unit&)) {
  return [change] {
    return [change](const UnitWorker& right, const Unit& unit, base::BytesView state) {
      Unit other = unit;
      change(other);
      return run_other(right, unit, other, state);
    };
  };
}

std::function<Run()> afterwards(void (*change)(UnitResult&)) {
  return [change] {
    return [change](const UnitWorker& right, const Unit& unit, base::BytesView state) {
      UnitResult result = right.run(unit, state);
      change(result);
      return result;
    };
  };
}

/// Returns whether a lineage begins with the unit's scan.
bool is_fresh(const Unit& unit) {
  return unit.starts || unit.inverse_temperature(0) == 0;
}

Run report_the_last_density() {
  auto last = std::make_shared<std::map<plan::ReplicaKey, double>>();
  return [last](const UnitWorker& right, const Unit& unit, base::BytesView state) {
    UnitResult result = right.run(unit, state);
    double& l = result.scans.front().log_constraint;
    const auto known = last->find(unit.replica);
    const double now = l;
    if (known != last->end()) l = known->second;
    (*last)[unit.replica] = now;
    return result;
  };
}

Run count_calls() {
  auto calls = std::make_shared<std::uint64_t>(0);
  return [calls](const UnitWorker& right, const Unit& unit, base::BytesView state) {
    Unit other = unit;
    if (!unit.starts) other.first_scan.value += 1000 * ++*calls;
    return run_other(right, unit, other, state);
  };
}

Run states_stay_with_levels() {
  struct Level {
    base::ReplicaId replica;
    base::Bytes state;
  };
  auto levels = std::make_shared<std::map<double, Level>>();
  return [levels](const UnitWorker& right, const Unit& unit, base::BytesView state) {
    // Use one replica id per level. Otherwise the worker's cache could supply the right state.
    const double beta = unit.inverse_temperature(0);
    const auto found = levels->find(beta);
    Unit other = unit;
    other.replica.replica.value = found != levels->end()
                                      ? found->second.replica.value
                                      : 1000 + static_cast<std::uint32_t>(levels->size());
    UnitResult result = run_other(
        right, unit, other, found != levels->end() ? base::BytesView(found->second.state) : state);
    (*levels)[beta] = {other.replica.replica, result.state_after};
    return result;
  };
}

void to_a_hotter_level(Unit& unit) {
  const std::vector<double>& ladder = ladder_of_checks();
  for (double& beta : unit.inverse_temperatures) {
    const auto level = std::ranges::find(ladder, beta);
    if (level != ladder.end() && level - ladder.begin() >= 2) beta = *std::prev(level);
  }
}

OnTheWay sizes_follow_acceptance() {
  auto factors = std::make_shared<std::map<plan::ReplicaKey, double>>();
  return {.handed_out =
              [factors](Unit& unit) {
                for (double& scale : unit.proposal_scales)
                  scale *= factors->emplace(unit.replica, 1.0).first->second;
              },
          .taken_in =
              [factors](const plan::ReplicaKey& replica, std::vector<plan::ScanRecord>& records) {
                double& factor = factors->emplace(replica, 1.0).first->second;
                for (const plan::ScanRecord& record : records) {
                  for (const std::uint32_t accepted : record.accepted)
                    factor *= accepted > 0 ? 1.1 : 0.95;
                }
              }};
}

OnTheWay ladder_follows_density() {
  auto last = std::make_shared<double>(0);
  auto asked = std::make_shared<std::map<plan::ReplicaKey, Unit>>();
  return {.handed_out =
              [last, asked](Unit& unit) {
                (*asked)[unit.replica] = unit;
                for (double& beta : unit.inverse_temperatures) {
                  if (beta > 0 && beta < 1 && *last < -1) beta *= 0.9;
                }
              },
          .taken_in =
              [last, asked](const plan::ReplicaKey& key, std::vector<plan::ScanRecord>& records) {
                *last = records.back().log_constraint;
                // Write the expected temperatures into the records, because a plan refuses wrong
                // temperatures.
                for (std::uint32_t nth = 0; nth < records.size(); ++nth)
                  records[nth].inverse_temperature = asked->at(key).inverse_temperature(nth);
              }};
}

OnTheWay every_scan_a_solution() {
  auto next = std::make_shared<std::uint64_t>(0);
  return {.handed_out = {},
          .taken_in = [next](const plan::ReplicaKey&, std::vector<plan::ScanRecord>& records) {
            for (plan::ScanRecord& record : records)
              record.lineage = (std::uint64_t{1} << 40U) + ++*next;
          }};
}

}  // namespace

std::vector<Mutant> wrong_workers() {
  using enum CheckId;
  return {
      {.name = "level off by one",
       .what = "scans are made at the inverse temperature of the next hotter level",
       .checks = {ladder_keeps},
       .worker = instead(to_a_hotter_level)},
      {.name = "scans' numbers reused",
       .what = "every scan of a replica has the random numbers of its first",
       .checks = {scans_move},
       .worker = instead([](Unit& unit) { unit.first_scan.value = unit.starts ? 0 : 1; })},
      {.name = "replicas share numbers",
       .what = "all replicas of a ladder have the same random numbers",
       .checks = {draws_are_fresh},
       .worker = instead([](Unit& unit) { unit.replica.replica.value = 0; })},
      {.name = "chains share numbers",
       .what = "every two chains have the same random numbers",
       .checks = {draws_are_fresh},
       .worker = instead([](Unit& unit) { unit.replica.chain.value &= ~1U; })},
      {.name = "no fresh draw",
       .what = "at inverse temperature 0 the old state stays",
       .checks = {draws_are_fresh},
       .worker =
           [] {
             return [](const UnitWorker& right, const Unit& unit, base::BytesView state) {
               UnitResult result = right.run(unit, state);
               if (unit.starts || unit.inverse_temperature(0) != 0) return result;
               result.state_after = base::Bytes(state.begin(), state.end());
               const std::uint32_t place = Ring{}.decode(state).value();
               result.scans.front().outcome = {static_cast<double>(place)};
               result.scans.front().log_constraint = Ring{}.log_constraint(place);
               return result;
             };
           }},
      {.name = "a step for a fresh draw",
       .what = "at inverse temperature 0 the chain makes a step where it should draw afresh",
       .checks = {draws_are_fresh},
       .worker = instead([](Unit& unit) {
         if (!unit.starts && unit.inverse_temperature(0) == 0) unit.inverse_temperatures = {1e-9};
       })},
      {.name = "last scan's density",
       .what = "a scan reports the constraint's density of the scan before",
       .checks = {ladder_keeps},
       .worker = report_the_last_density},
      {.name = "numbers by the call",
       .what = "random numbers follow the count of calls, not the scan",
       .checks = {results_are_pure},
       .worker = count_calls},
      {.name = "swaps in the books alone",
       .what = "temperatures swap but each state stays at its level",
       .checks = {parts_are_found},
       .worker = states_stay_with_levels},
      {.name = "lineage not reset",
       .what = "a fresh draw at inverse temperature 0 keeps the old lineage",
       .checks = {lineages_are_right},
       .worker = afterwards([](UnitResult& result) {
         if (!result.unit.starts) result.scans.front().lineage = result.unit.lineage;
       })},
      {.name = "lineage reset too often",
       .what = "every scan below inverse temperature 0.2 begins a lineage",
       .checks = {lineages_are_right},
       .worker = afterwards([](UnitResult& result) {
         if (result.unit.inverse_temperature(0) < 0.2)
           result.scans.front().lineage =
               plan::lineage_from(result.unit.replica.replica, result.unit.first_scan.value);
       })},
      {.name = "lineages run together",
       .what = "a fresh draw's lineage is numbered by its replica alone",
       .checks = {lineages_are_right},
       .worker = afterwards([](UnitResult& result) {
         if (is_fresh(result.unit))
           result.scans.front().lineage = result.unit.replica.replica.value;
       })},
      {.name = "excursion keeps its lineage",
       .what = "what a tempered transition brings from the prior counts as its old self",
       .checks = {excursions_descend},
       .worker = afterwards([](UnitResult& result) {
         if (!result.unit.excursion.empty()) result.scans.front().lineage = result.unit.lineage;
       })},
      {.name = "sizes adapt within a round",
       .what = "a replica's proposals grow with every acceptance",
       .checks = {rounds_are_frozen},
       .way = sizes_follow_acceptance},
      {.name = "ladder adapts within a round",
       .what = "inverse temperatures follow what was seen last",
       .checks = {rounds_are_frozen},
       .way = ladder_follows_density},
      {.name = "every scan a solution",
       .what = "solutions are counted by scan where they should be by lineage",
       .checks = {lineages_are_right},
       .way = every_scan_a_solution},
  };
}

}  // namespace sleight::statistical
