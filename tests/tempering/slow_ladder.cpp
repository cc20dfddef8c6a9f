#include "tests/tempering/slow_ladder.h"

#include <algorithm>
#include <bit>
#include <set>

#include "tests/support/numbers.h"
#include "tests/tempering/tempering_loop.h"

namespace sleight::sampling {
namespace {

/// Sebastiano Vigna's splitmix64.
std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  std::uint64_t x = (a ^ b) + 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}
double uniform_of(std::uint64_t bits) {
  return static_cast<double>(bits >> 11U) * 0x1p-53;
}

struct EndVisit {
  std::uint64_t scan = 0;
  bool coolest = false;
};

/// Counts the round trips and restarts of a replica in each round. Uses the replica's whole path.
void count_trips(const std::vector<EndVisit>& visits, std::vector<RoundReport>& rounds) {
  const auto round_at = [&](std::uint64_t scan) -> RoundReport& {
    std::size_t round = rounds.size() - 1;
    while (rounds[round].first_scan > scan)
      --round;
    return rounds[round];
  };
  // Consecutive visits to the same end count as one visit.
  std::vector<EndVisit> ends;
  for (const EndVisit& visit : visits) {
    if (ends.empty() || ends.back().coolest != visit.coolest) ends.push_back(visit);
  }
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (ends[i].coolest) ++round_at(ends[i].scan).restarts;
    if (!ends[i].coolest && i >= 2) ++round_at(ends[i].scan).round_trips;
  }
}

}  // namespace

plan::UnitResult HashedWorker::run(const plan::Unit& unit, base::BytesView state) const {
  plan::UnitResult result{.unit = unit, .scans = {}, .state_after = {}};
  std::uint64_t hash = base::ByteReader(state).get<std::uint64_t>().value_or(0);
  hash = mixed(hash, options_.seed);
  hash = mixed(hash, unit.replica.chain.value);
  hash = mixed(hash, unit.replica.replica.value);
  hash = mixed(hash, unit.starts ? 1 : 0);
  hash = mixed(hash, unit.lineage);
  for (const double scale : unit.proposal_scales)
    hash = mixed(hash, std::bit_cast<std::uint64_t>(scale));
  std::uint64_t lineage = unit.lineage;
  for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
    const std::uint64_t scan = unit.first_scan.value + nth;
    const double beta = unit.inverse_temperature(nth);
    hash = mixed(mixed(hash, scan), std::bit_cast<std::uint64_t>(beta));
    if ((unit.starts && nth == 0) || beta == 0)
      lineage = plan::lineage_from(unit.replica.replica, scan);
    const std::uint64_t phase = mixed(options_.seed, scan / 32) % options_.roughness.size();
    const double l = -options_.roughness[phase] * uniform_of(mixed(hash, 1));
    const bool broken = uniform_of(mixed(hash, 2)) < options_.broken;
    const auto accepted = static_cast<std::uint32_t>(mixed(hash, 3) % 4);
    result.scans.push_back({.log_prior = 0,
                            .log_constraint = broken ? -k_infinity : l,
                            .satisfied = uniform_of(mixed(hash, 4)) < options_.satisfied,
                            .lineage = lineage,
                            .inverse_temperature = beta,
                            .proposed = {3, 2},
                            .accepted = {accepted, accepted / 2},
                            .outcome = {},
                            .state = {}});
  }
  base::ByteWriter writer;
  writer.put(hash);
  result.state_after = writer.take();
  return result;
}

SlowLadder slow_ladder(const LadderOptions& options, const plan::UnitWorker& worker,
                       std::uint64_t scans) {
  SlowLadder slow;
  std::map<std::uint32_t, base::Bytes> states;
  std::map<std::uint32_t, std::uint64_t> lineages;
  std::map<std::uint32_t, std::vector<EndVisit>> visits;
  std::set<std::uint64_t> solved;
  slow.rounds = tempering_loop(options, scans, [&](const LoopScan& scan) {
    const plan::Unit unit{
        .replica = {options.chain, base::ReplicaId{scan.replica}},
        .seed = options.seed,
        .first_scan = base::ScanIndex{scan.scan},
        .scans = 1,
        .starts = !states.contains(scan.replica),
        .lineage = lineages[scan.replica],
        .inverse_temperatures = {scan.inverse_temperature},
        .proposal_scales = {scan.proposal_scales.begin(), scan.proposal_scales.end()},
        .excursion = {}};
    const plan::UnitResult done = worker.run(unit, states[scan.replica]);
    slow.units.emplace(SlowLadder::Place{scan.replica, scan.scan}, unit);
    slow.results.emplace(SlowLadder::Place{scan.replica, scan.scan}, done);
    states[scan.replica] = done.state_after;
    const plan::ScanRecord& record = done.scans.front();
    lineages[scan.replica] = record.lineage;
    // A ladder's ends are at 0 and 1. Scans of annealing don't count as visits to an end.
    if (scan.scan < options.anneal_scans) return record;
    if (scan.inverse_temperature == 0) visits[scan.replica].push_back({scan.scan, false});
    if (scan.inverse_temperature == 1) {
      visits[scan.replica].push_back({scan.scan, true});
      if (record.satisfied && solved.insert(record.lineage).second)
        slow.solutions.push_back(scan.scan);
    }
    return record;
  });
  for (const auto& [replica, ends] : visits)
    count_trips(ends, slow.rounds);
  return slow;
}

std::vector<std::uint64_t> fingerprint(std::span<const RoundReport> rounds,
                                       std::span<const std::uint64_t> solutions) {
  std::vector<std::uint64_t> bits;
  const auto put = [&](const auto& numbers) {
    bits.push_back(numbers.size());
    for (const double number : numbers)
      bits.push_back(std::bit_cast<std::uint64_t>(number));
  };
  const auto put_whole = [&](const auto& numbers) {
    bits.push_back(numbers.size());
    bits.insert(bits.end(), numbers.begin(), numbers.end());
  };
  for (const RoundReport& round : rounds) {
    put_whole(std::vector<std::uint64_t>{round.first_scan, round.statistics.scans(),
                                         round.round_trips, round.restarts});
    put(round.statistics.ladder());
    for (const std::vector<double>& scales : round.scales)
      put(scales);
    for (const KindCounts& counts : round.counts) {
      put_whole(counts.proposed);
      put_whole(counts.accepted);
    }
    if (round.statistics.scans() == 0) continue;
    put(round.statistics.rejections());
    const Estimate log_z = round.statistics.log_z();
    const Estimate log_satisfied = round.statistics.log_satisfied();
    put(std::vector{log_z.value, log_z.error, log_satisfied.value, log_satisfied.error});
  }
  put_whole(solutions);
  return bits;
}

}  // namespace sleight::sampling
