#include "worker/sampling/ladder_run.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/sampling/ladder.h"

namespace sleight::sampling {
namespace {

SwapFlow flow_of(const LadderOptions& options, const std::vector<double>& ladder) {
  return SwapFlow({.seed = options.seed,
                   .chain = options.chain,
                   .levels = static_cast<std::uint32_t>(ladder.size()),
                   .first_level = 0,
                   .inverse_temperatures = ladder});
}

}  // namespace

LadderRun::LadderRun(const LadderOptions& options)
    : options_(options), flow_(flow_of(options, options.first_ladder)) {
  CHECK_GE(options.first_ladder.size(), std::size_t{k_levels_min});
  CHECK_EQ(options.first_ladder.front(), 0.0);
  CHECK_EQ(options.first_ladder.back(), 1.0);
  CHECK_LT(options.levels_max, plan::k_replicas_end);
  CHECK_GE(options.round_scans, 1U);
  const auto levels = static_cast<std::uint32_t>(options.first_ladder.size());
  retired_ = options.anneal_scans;
  rounds_.push_back(first_round(options));
  replicas_.resize(levels);
  for (Replica& replica : replicas_)
    replica.lives = true;
  for (std::uint32_t level = 0; level < levels; ++level)
    flow_.sit(level, level, options.anneal_scans);
  if (options.anneal_scans > 0) return;
  for (std::uint32_t level = 0; level < levels; ++level)
    place(level, level, 0);
}

std::uint64_t LadderRun::scans() const {
  if (options_.anneal_scans == 0 || retired_ > options_.anneal_scans) return retired_;
  std::uint64_t least = options_.anneal_scans;
  for (std::size_t level = 0; level < ladder().size(); ++level)
    least = std::min(least, replicas_[level].next_scan);
  return least;
}

std::uint64_t LadderRun::records_counted() const {
  return records_counted_ + options_.first_ladder.size() * std::min(scans(), options_.anneal_scans);
}

std::uint64_t LadderRun::round_trips() const {
  std::uint64_t sum = 0;
  for (const RoundReport& round : rounds_)
    sum += round.round_trips;
  return sum;
}

std::vector<plan::EndedRound> LadderRun::rounds_between(std::uint64_t after,
                                                        std::uint64_t until) const {
  std::vector<plan::EndedRound> ended;
  for (std::size_t nth = 0; nth < rounds_.size() && rounds_[nth].end_scan() <= until; ++nth) {
    const RoundReport& round = rounds_[nth];
    if (round.end_scan() <= after) continue;
    ended.push_back({.chain = options_.chain,
                     .round = nth + 1,
                     .scans = round.end_scan(),
                     .swaps = round.mean_swap_acceptance(),
                     .round_trips = round.round_trips});
  }
  return ended;
}

BurnIn LadderRun::burn_in() const {
  CHECK_GE(rounds_.size(), 2U);
  CHECK_EQ(rounds_.back().first_scan, retired_);
  const RoundReport& last = rounds_[rounds_.size() - 2];
  CHECK_EQ(flow_.seat(flow_.size() - 1).scan, retired_);
  const std::uint32_t coolest = *flow_.seat(flow_.size() - 1).replica;
  return {.seed = options_.seed,
          .chain = options_.chain,
          .scans = retired_,
          .coolest = base::ReplicaId{coolest},
          .first_free = base::ReplicaId{replicas()},
          .lineage = replicas_[coolest].lineage,
          .ladder = last.statistics.ladder(),
          .scales = last.scales,
          .log_z_steps = last.statistics.log_z_steps(),
          .next_ladder = ladder(),
          .next_scales = rounds_.back().scales};
}

LadderRun::Row& LadderRun::row(std::uint64_t scan) {
  CHECK_GE(scan, retired_);
  while (rows_.size() <= scan - retired_)
    rows_.push_back({.replica = std::vector<std::uint32_t>(levels(), k_nobody),
                     .result = std::vector<std::optional<Result>>(levels())});
  return rows_[scan - retired_];
}

void LadderRun::place(std::uint32_t replica, std::uint32_t level, std::uint64_t scan) {
  CHECK_EQ(replicas_[replica].next_scan, scan);
  row(scan).replica[level] = replica;
  replicas_[replica].level = level;
}

void LadderRun::consume(base::ReplicaId id, std::uint64_t first_scan,
                        std::span<const plan::ScanRecord> records) {
  // A run store may deliver a replica's results before the ladder creates the replica.
  if (id.value >= replicas_.size()) {
    CHECK_LT(id.value, plan::k_replicas_end);
    replicas_.resize(id.value + 1);
  }
  Replica& replica = replicas_[id.value];
  if (!replica.lives && replica.waiting.empty())
    replica.first_scan = replica.next_scan = first_scan;
  CHECK_EQ(first_scan, replica.next_scan + replica.waiting.size());
  for (const plan::ScanRecord& record : records)
    replica.waiting.push_back({.log_prior = record.log_prior,
                               .log_constraint = record.log_constraint,
                               .satisfied = record.satisfied,
                               .lineage = record.lineage,
                               .inverse_temperature = record.inverse_temperature,
                               .proposed = record.proposed,
                               .accepted = record.accepted});
  records_ += records.size();
  replica.handed_out = false;
  std::vector<std::uint32_t> ready{id.value};
  settle(ready);
}

/// Consumes results as long as their levels are known, and makes the swaps that become possible.
void LadderRun::settle(std::vector<std::uint32_t>& ready) {
  while (!ready.empty()) {
    const std::uint32_t id = ready.back();
    ready.pop_back();
    while (!replicas_[id].waiting.empty()) {
      Replica& replica = replicas_[id];
      if (replica.next_scan < options_.anneal_scans) {
        replica.lineage = replica.waiting.front().lineage;
        replica.waiting.pop_front();
        if (++replica.next_scan == options_.anneal_scans) place(id, id, replica.next_scan);
        continue;
      }
      if (replica.level == k_nobody) break;
      const std::uint64_t scan = replica.next_scan++;
      const std::uint32_t level = std::exchange(replica.level, k_nobody);
      replica.lineage = replica.waiting.front().lineage;
      // Verify that the worker ran the scan at this level, as a unit or in a block.
      CHECK_EQ(replica.waiting.front().inverse_temperature, ladder()[level]);
      const double log_constraint = replica.waiting.front().log_constraint;
      row(scan).result[level] = std::move(replica.waiting.front());
      replica.waiting.pop_front();
      // At a round's end, the next temperature of a level is unknown.
      for (const SwapFlow::GoesOn& goes : flow_.made(level, log_constraint)) {
        if (goes.scan == round_end()) continue;
        place(goes.replica, goes.level, goes.scan);
        ready.push_back(goes.replica);
      }
      retire();
      const bool round_is_over = retired_ == round_end();
      if (round_is_over) begin_round(ready);
    }
  }
}

const Solutions& LadderRun::solutions_since(std::uint64_t first_scan) const {
  const auto found = std::ranges::find(solutions_, first_scan, &SolutionsSince::first_scan);
  CHECK(found != solutions_.end());
  return found->since;
}

/// Whether a lineage descends from a search's find. All replicas but the hottest start from finds.
bool LadderRun::began_by_search(std::uint64_t lineage) const {
  return options_.starts_by_search && lineage != 0 && plan::scan_of_lineage(lineage) == 0;
}

/// Counts, in order, the scans that all levels have completed.
void LadderRun::retire() {
  while (!rows_.empty() && retired_ < round_end() &&
         std::ranges::all_of(rows_.front().result, [](const auto& r) { return r.has_value(); })) {
    RoundReport& round = rounds_.back();
    std::vector<LevelScan> scan;
    for (std::uint32_t level = 0; level < levels(); ++level) {
      const Result& result = *rows_.front().result[level];
      scan.push_back({.log_constraint = result.log_constraint, .satisfied = result.satisfied});
      round.counts[level].add(result.proposed, result.accepted);
      if (began_by_search(result.lineage)) searched_until_ = retired_ + 1;
      count_trip(rows_.front().replica[level], level);
    }
    round.statistics.add(scan);
    index_process_.add(retired_, rows_.front().replica);
    for (SolutionsSince& solutions : solutions_)
      solutions.since.add(retired_, *rows_.front().result.back());
    rows_.pop_front();
    ++retired_;
    records_counted_ += levels();
  }
}

void LadderRun::count_trip(std::uint32_t id, std::uint32_t level) {
  Replica& replica = replicas_[id];
  RoundReport& round = rounds_.back();
  if (level == 0) {
    if (replica.way == Way::down) ++round.round_trips;
    replica.way = Way::up;
  } else if (level + 1 == levels() && replica.way == Way::up) {
    ++round.restarts;
    replica.way = Way::down;
  }
}

/// Begins a round. REQUIRES: all replicas have reached the last round's end.
void LadderRun::begin_round(std::vector<std::uint32_t>& ready) {
  rounds_.push_back(next_round(options_, rounds_.back()));
  if (options_.starts_by_search) solutions_.push_back({.first_scan = retired_});
  const std::vector<std::uint32_t> at = replicas_of_new_round();
  flow_ = flow_of(options_, ladder());
  rows_.clear();
  for (std::uint32_t level = 0; level < levels(); ++level) {
    flow_.sit(level, at[level], retired_);
    place(at[level], level, retired_);
    ready.push_back(at[level]);
  }
}

/// Returns the replicas by level. The coolest replicas stay coolest; new replicas become the
/// hottest.
std::vector<std::uint32_t> LadderRun::replicas_of_new_round() {
  const std::uint32_t stay = std::min(flow_.size(), levels());
  std::vector<std::uint32_t> at;
  while (at.size() + stay < levels()) {
    // Take the lowest unused id. A run store may already have delivered results of this replica.
    const auto unborn = std::ranges::find(replicas_, false, &Replica::lives);
    const auto id = static_cast<std::uint32_t>(unborn - replicas_.begin());
    if (id == replicas_.size()) replicas_.emplace_back();
    Replica& replica = replicas_[id];
    CHECK(replica.waiting.empty() || replica.first_scan == retired_);
    replica.first_scan = replica.next_scan = retired_;
    replica.lives = true;
    at.push_back(id);
  }
  for (std::uint32_t level = flow_.size() - stay; level < flow_.size(); ++level)
    at.push_back(*flow_.seat(level).replica);
  return at;
}

}  // namespace sleight::sampling
