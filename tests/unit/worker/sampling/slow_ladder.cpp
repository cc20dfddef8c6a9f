#include "tests/unit/worker/sampling/slow_ladder.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <set>

#include "common/math/elementary.h"
#include "common/random/stream.h"
#include "worker/sampling/ladder.h"

namespace sleight::sampling {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

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

/// Which ends of the ladder a replica has come to, in order, and when.
struct EndVisit {
  std::uint64_t scan = 0;
  bool coolest = false;
};

/// Counts in the rounds what is read off a replica's whole way.
void count_trips(const std::vector<EndVisit>& visits, std::vector<RoundReport>& rounds) {
  const auto round_at = [&](std::uint64_t scan) -> RoundReport& {
    std::size_t round = rounds.size() - 1;
    while (rounds[round].first_scan > scan)
      --round;
    return rounds[round];
  };
  // Visits in a row to one end are one.
  std::vector<EndVisit> ends;
  for (const EndVisit& visit : visits) {
    if (ends.empty() || ends.back().coolest != visit.coolest) ends.push_back(visit);
  }
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (ends[i].coolest) ++round_at(ends[i].scan).restarts;
    if (!ends[i].coolest && i >= 2) ++round_at(ends[i].scan).round_trips;
  }
}

class Slow {
 public:
  Slow(const LadderOptions& options, const plan::UnitWorker& worker)
      : options_(options), worker_(worker) {
    begin_round(options.anneal_scans, options.first_ladder, {});
  }

  void scan(std::uint64_t scan) {
    if (scan < options_.anneal_scans) {
      anneal(scan);
      return;
    }
    // Everyone makes the scan.
    std::vector<plan::ScanRecord> records;
    std::vector<LevelScan> levels;
    RoundReport& round = result_.rounds.back();
    for (std::uint32_t level = 0; level < at_.size(); ++level) {
      const std::uint32_t replica = at_[level];
      const plan::Unit unit{.replica = {options_.chain, base::ReplicaId{replica}},
                            .seed = options_.seed,
                            .first_scan = base::ScanIndex{scan},
                            .scans = 1,
                            .starts = !states_.contains(replica),
                            .lineage = lineages_[replica],
                            .inverse_temperatures = {ladder()[level]},
                            .proposal_scales = round.scales[level],
                            .excursion = {}};
      const plan::ScanRecord& record = records.emplace_back(run(unit));
      levels.push_back({.log_constraint = record.log_constraint, .satisfied = record.satisfied});
      round.counts[level].add(record.proposed, record.accepted);
      if (level == 0) visits_[replica].push_back({scan, false});
      if (level + 1 == at_.size()) visits_[replica].push_back({scan, true});
    }
    round.statistics.add(levels);
    if (records.back().satisfied && solved_.insert(records.back().lineage).second)
      result_.solutions.push_back(scan);

    // The pairs of this parity swap.
    for (std::uint32_t i = scan % 2; i + 1 < at_.size(); i += 2) {
      const double l = records[i].log_constraint;
      const double cooler = records[i + 1].log_constraint;
      const double ratio = l == cooler ? 0 : (ladder()[i + 1] - ladder()[i]) * (l - cooler);
      random::Stream stream({.seed = options_.seed,
                             .chain = options_.chain,
                             .replica = base::ReplicaId{i},
                             .purpose = random::Purpose::swap},
                            scan);
      if (math::log(stream.uniform()) < ratio) std::swap(at_[i], at_[i + 1]);
    }

    // The round may be over.
    const std::uint64_t length = options_.round_scans << (result_.rounds.size() - 1);
    if (scan + 1 == round.first_scan + length) learn(scan + 1);
  }

  SlowLadder result() {
    for (const auto& [replica, visits] : visits_)
      count_trips(visits, result_.rounds);
    return result_;
  }

 private:
  const std::vector<double>& ladder() const { return result_.rounds.back().statistics.ladder(); }

  plan::ScanRecord run(const plan::Unit& unit) {
    const std::uint32_t replica = unit.replica.replica.value;
    const plan::UnitResult done = worker_.run(unit, states_[replica]);
    result_.units.emplace(SlowLadder::Place{replica, unit.first_scan.value}, unit);
    result_.results.emplace(SlowLadder::Place{replica, unit.first_scan.value}, done);
    states_[replica] = done.state_after;
    lineages_[replica] = done.scans.front().lineage;
    return done.scans.front();
  }

  /// Everyone is on the way to the temperature that it begins with.
  void anneal(std::uint64_t scan) {
    const double share = static_cast<double>(scan) / static_cast<double>(options_.anneal_scans);
    for (std::uint32_t replica = 0; replica < at_.size(); ++replica) {
      run({.replica = {options_.chain, base::ReplicaId{replica}},
           .seed = options_.seed,
           .first_scan = base::ScanIndex{scan},
           .scans = 1,
           .starts = scan == 0,
           .lineage = lineages_[replica],
           .inverse_temperatures = {options_.first_ladder[replica] * share},
           .proposal_scales = {},
           .excursion = {}});
    }
  }

  void learn(std::uint64_t scan) {
    const RoundReport& last = result_.rounds.back();
    const std::vector<double> old = ladder();
    const std::vector<double> rejections = last.statistics.rejections();
    std::uint32_t levels = static_cast<std::uint32_t>(old.size());
    double barrier = 0;
    for (const double rejection : rejections)
      barrier += rejection;
    if (options_.levels_chosen) levels = std::min(levels_for(barrier), options_.levels_max);
    const bool moves = options_.ladder_adapts || levels != old.size();
    const std::vector<double> next = moves ? respaced(old, rejections, levels) : old;

    std::vector<std::vector<double>> scales(levels);
    const bool any = std::ranges::count(options_.has_scale, true) > 0;
    const std::size_t kinds = any ? last.counts[0].proposed.size() : 0;
    for (std::size_t kind = 0; kind < kinds; ++kind) {
      std::vector<double> logs;
      for (std::size_t level = 0; level < old.size(); ++level)
        logs.push_back(
            math::log(tuned(last.scales[level], last.counts[level], options_.has_scale)[kind]));
      logs[0] = logs[1];
      for (std::size_t level = 0; level < levels; ++level)
        scales[level].push_back(math::exp(interpolated(old, logs, next[level])));
    }
    begin_round(scan, next, scales);
  }

  void begin_round(std::uint64_t scan, const std::vector<double>& ladder,
                   std::vector<std::vector<double>> scales) {
    scales.resize(ladder.size());
    while (at_.size() > ladder.size())
      at_.erase(at_.begin());
    // New ones are the hottest, their numbers ascending from the hot end.
    std::vector<std::uint32_t> born;
    while (at_.size() + born.size() < ladder.size())
      born.push_back(births_++);
    at_.insert(at_.begin(), born.begin(), born.end());
    result_.rounds.push_back(
        {.first_scan = scan,
         .statistics = RoundStatistics(ladder, options_.round_scans << result_.rounds.size()),
         .round_trips = 0,
         .restarts = 0,
         .counts = std::vector<KindCounts>(ladder.size()),
         .scales = std::move(scales)});
  }

  LadderOptions options_;
  const plan::UnitWorker& worker_;
  SlowLadder result_;
  std::vector<std::uint32_t> at_;  ///< by level: the replica
  std::uint32_t births_ = 0;
  std::map<std::uint32_t, base::Bytes> states_;
  std::map<std::uint32_t, std::uint64_t> lineages_;
  std::map<std::uint32_t, std::vector<EndVisit>> visits_;
  std::set<std::uint64_t> solved_;
};

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
  Slow slow(options, worker);
  for (std::uint64_t scan = 0; scan < scans; ++scan)
    slow.scan(scan);
  return slow.result();
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
