#include "worker/sampling/ladder_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/check.h"
#include "common/math/elementary.h"
#include "worker/sampling/ladder.h"

namespace sleight::sampling {

namespace {

/// All levels of a round.
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
  rounds_.push_back({.first_scan = options.anneal_scans,
                     .statistics = RoundStatistics(options.first_ladder, options.round_scans),
                     .round_trips = 0,
                     .restarts = 0,
                     .counts = std::vector<KindCounts>(levels),
                     .scales = std::vector<std::vector<double>>(levels)});
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

/// A part of the way from the prior to the temperature that the replica has at first.
plan::Unit LadderRun::anneal(std::uint32_t id, std::uint32_t scans_max) const {
  const Replica& replica = replicas_[id];
  const std::uint64_t scans =
      std::min<std::uint64_t>(options_.anneal_scans - replica.next_scan, scans_max);
  return {.replica = {options_.chain, base::ReplicaId{id}},
          .seed = options_.seed,
          .first_scan = base::ScanIndex{replica.next_scan},
          .scans = static_cast<std::uint32_t>(scans),
          .starts = replica.next_scan == 0,
          .lineage = replica.lineage,
          .inverse_temperatures =
              annealing(options_.first_ladder[id], options_.anneal_scans, replica.next_scan, scans),
          .proposal_scales = {},
          .excursion = {}};
}

std::uint64_t LadderRun::round_end() const {
  return rounds_.back().first_scan + (options_.round_scans << (rounds_.size() - 1));
}

LadderRun::Row& LadderRun::row(std::uint64_t scan) {
  CHECK_GE(scan, retired_);
  while (rows_.size() <= scan - retired_)
    rows_.push_back({.replica = std::vector<std::uint32_t>(levels(), k_nobody),
                     .result = std::vector<std::optional<Result>>(levels())});
  return rows_[scan - retired_];
}

/// A replica's level at a scan is known.
void LadderRun::place(std::uint32_t replica, std::uint32_t level, std::uint64_t scan) {
  CHECK_EQ(replicas_[replica].next_scan, scan);
  row(scan).replica[level] = replica;
  replicas_[replica].level = level;
}

bool LadderRun::may_run(std::uint32_t id, std::uint64_t horizon) const {
  const Replica& replica = replicas_[id];
  const bool anneals = replica.lives && replica.next_scan < options_.anneal_scans;
  if (replica.level == k_nobody && !anneals) return false;
  return !replica.handed_out && replica.next_scan < horizon;
}

/// Of those that may run the lowest id among equals, or nobody.
std::uint32_t LadderRun::furthest_behind(std::uint64_t horizon) const {
  std::uint32_t chosen = k_nobody;
  for (std::uint32_t id = 0; id < replicas_.size(); ++id) {
    if (!may_run(id, horizon)) continue;
    if (chosen == k_nobody || replicas_[id].next_scan < replicas_[chosen].next_scan) chosen = id;
  }
  return chosen;
}

/// The next scan of a replica whose level is known.
plan::Unit LadderRun::scan_of(std::uint32_t id) const {
  const Replica& replica = replicas_[id];
  return {.replica = {options_.chain, base::ReplicaId{id}},
          .seed = options_.seed,
          .first_scan = base::ScanIndex{replica.next_scan},
          .scans = 1,
          .starts = replica.next_scan == replica.first_scan,
          .lineage = replica.lineage,
          .inverse_temperatures = {ladder()[replica.level]},
          .proposal_scales = rounds_.back().scales[replica.level],
          .excursion = {}};
}

std::optional<plan::Unit> LadderRun::next_unit(std::uint64_t horizon, std::uint32_t scans_max) {
  const std::uint32_t chosen = furthest_behind(horizon);
  if (chosen == k_nobody) return std::nullopt;
  Replica& replica = replicas_[chosen];
  replica.handed_out = true;
  if (replica.next_scan >= options_.anneal_scans) return scan_of(chosen);
  const std::uint64_t left = horizon - replica.next_scan;
  return anneal(chosen, static_cast<std::uint32_t>(std::min<std::uint64_t>(left, scans_max)));
}

/// Where a block of the whole ladder ends: at the end of a row, so that all levels can go on in one
/// block again, and of as many rows as the limit has scans for; at least one that isn't begun.
std::uint64_t LadderRun::whole_rows_end(std::span<const std::uint32_t> ready,
                                        std::uint64_t end_scan, std::uint64_t scans_max) const {
  std::uint64_t begin = 0;  // of the first row that nobody has begun
  std::uint64_t sum = 0;
  for (const std::uint32_t id : ready) {
    begin = std::max(begin, replicas_[id].next_scan);
    sum += replicas_[id].next_scan;
  }
  const std::uint64_t most = (scans_max + sum) / ready.size();
  return std::min(end_scan, std::max(begin + 1, most));
}

std::optional<plan::Block> LadderRun::next_block(std::uint64_t horizon,
                                                 const plan::BlockLimits& limits,
                                                 std::size_t ladders) {
  const std::uint32_t chosen = furthest_behind(horizon);
  if (chosen == k_nobody) return std::nullopt;
  const bool alone =
      limits.block_scans_max <= 1 || replicas_[chosen].next_scan < options_.anneal_scans;
  if (alone) {
    return plan::Block{.members = {*next_unit(horizon, limits.unit_scans_max)}, .ladder = {}};
  }

  // Who is ready at each level: one at most, since a level's scans come one after the other.
  std::vector<std::uint32_t> ready(levels(), k_nobody);
  for (std::uint32_t id = 0; id < replicas_.size(); ++id) {
    if (replicas_[id].level != k_nobody && may_run(id, horizon)) ready[replicas_[id].level] = id;
  }

  const bool is_whole = std::ranges::find(ready, k_nobody) == ready.end();
  const bool waits_for_all = ladders >= limits.threads && levels() <= limits.whole_levels_max;
  if (waits_for_all && !is_whole && std::ranges::any_of(replicas_, &Replica::handed_out))
    return std::nullopt;

  // Neighbours join: all, if each can make a scan; else as many as come to the limit in a triangle
  // whose sides lose a level with each scan.
  std::uint32_t first = replicas_[chosen].level;
  std::uint32_t end = first + 1;
  const auto root = static_cast<std::uint64_t>(std::sqrt(2.0 * limits.block_scans_max));
  const std::uint64_t share =
      ladders >= limits.threads ? levels() : ladders * levels() / (2 * limits.threads);
  const bool has_scans_for_all = limits.block_scans_max >= levels();
  const bool takes_all = waits_for_all || (has_scans_for_all && share == levels());
  const std::uint64_t wanted =
      takes_all ? levels() : std::min(share, has_scans_for_all ? levels() : root);
  const auto joins = [&](std::uint32_t level) { return ready[level] != k_nobody; };
  for (bool grew = true; grew && end - first < wanted;) {
    grew = end < levels() && joins(end);
    if (grew) ++end;
    if (end - first < wanted && first > 0 && joins(first - 1)) {
      --first;
      grew = true;
    }
  }

  plan::Block block;
  plan::LadderPart& part = block.ladder.emplace();
  part = {.levels = levels(),
          .first_level = first,
          .inverse_temperatures = {},
          .proposal_scales = {},
          .end_scan = std::min(horizon, round_end()),
          .scans_max = limits.block_scans_max};
  if (is_whole && takes_all) {
    const std::uint64_t end_scan = whole_rows_end(ready, part.end_scan, limits.block_scans_max);
    std::uint64_t scans = 0;
    for (const std::uint32_t id : ready)
      scans += end_scan - replicas_[id].next_scan;
    if (waits_for_all || scans <= limits.block_scans_max) {
      part.end_scan = end_scan;
      part.scans_max = static_cast<std::uint32_t>(scans);
    }
  }
  for (std::uint32_t level = first; level < end; ++level) {
    block.members.push_back(scan_of(ready[level]));
    replicas_[ready[level]].handed_out = true;
    part.inverse_temperatures.push_back(ladder()[level]);
    part.proposal_scales.push_back(rounds_.back().scales[level]);
  }
  return block;
}

void LadderRun::consume(base::ReplicaId id, std::uint64_t first_scan,
                        std::span<const plan::ScanRecord> records) {
  // From a run store a replica's results may come before it is known that there will be one.
  if (id.value >= replicas_.size()) {
    CHECK_LT(id.value, plan::k_replicas_end);
    replicas_.resize(id.value + 1);
  }
  Replica& replica = replicas_[id.value];
  if (!replica.lives && replica.waiting.empty())
    replica.first_scan = replica.next_scan = first_scan;
  CHECK_EQ(first_scan, replica.next_scan + replica.waiting.size());
  for (const plan::ScanRecord& record : records)
    replica.waiting.push_back({.log_prior = 0,
                               .log_constraint = record.log_constraint,
                               .satisfied = record.satisfied,
                               .lineage = record.lineage,
                               .inverse_temperature = record.inverse_temperature,
                               .proposed = record.proposed,
                               .accepted = record.accepted,
                               .outcome = {},
                               .state = {}});
  records_ += records.size();
  replica.handed_out = false;
  std::vector<std::uint32_t> ready{id.value};
  settle(ready);
}

/// Puts results in their places as far as levels are known, and lets swaps follow from them.
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
      // Whoever ran it, alone or with its neighbours, had it at the same level.
      CHECK_EQ(replica.waiting.front().inverse_temperature, ladder()[level]);
      const double log_constraint = replica.waiting.front().log_constraint;
      row(scan).result[level] = std::move(replica.waiting.front());
      replica.waiting.pop_front();
      // At a round's end it isn't known yet which temperature a level will have.
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

/// Scans that all levels have are counted, in order.
void LadderRun::retire() {
  while (!rows_.empty() && retired_ < round_end() &&
         std::ranges::all_of(rows_.front().result, [](const auto& r) { return r.has_value(); })) {
    RoundReport& round = rounds_.back();
    std::vector<LevelScan> scan;
    for (std::uint32_t level = 0; level < levels(); ++level) {
      const Result& result = *rows_.front().result[level];
      scan.push_back({.log_constraint = result.log_constraint, .satisfied = result.satisfied});
      round.counts[level].add(result.proposed, result.accepted);
      count_trip(rows_.front().replica[level], level);
    }
    round.statistics.add(scan);
    solutions_.add(retired_, *rows_.front().result.back());
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

/// All replicas have reached the round's end: what it says becomes the next one's ladder.
void LadderRun::begin_round(std::vector<std::uint32_t>& ready) {
  const RoundReport& last = rounds_.back();
  const std::vector<double>& old = last.statistics.ladder();
  const std::vector<double> rejections = last.statistics.rejections();
  auto wanted = static_cast<std::uint32_t>(old.size());
  if (options_.levels_chosen)
    wanted = std::clamp(levels_for(cumulative_barrier(rejections).back()), k_levels_min,
                        options_.levels_max);
  std::vector<double> ladder = old;
  if (options_.ladder_adapts || wanted != old.size()) ladder = respaced(old, rejections, wanted);

  // Sizes of proposals are tuned where they were used, and read off there.
  std::vector<std::vector<double>> scales(wanted);
  if (std::ranges::find(options_.has_scale, true) != options_.has_scale.end()) {
    std::vector<std::vector<double>> learnt;
    std::size_t kinds = 0;
    for (std::size_t level = 0; level < old.size(); ++level) {
      learnt.push_back(tuned(last.scales[level], last.counts[level], options_.has_scale));
      kinds = std::max(kinds, learnt.back().size());
    }
    // The hottest level draws afresh and learns nothing: it goes with its neighbour.
    learnt.front() = learnt[1];
    for (std::size_t kind = 0; kind < kinds; ++kind) {
      std::vector<double> logs;
      for (const std::vector<double>& level : learnt)
        logs.push_back(kind < level.size() ? math::log(level[kind]) : 0);
      for (std::uint32_t level = 0; level < wanted; ++level)
        scales[level].push_back(math::exp(interpolated(old, logs, ladder[level])));
    }
  }

  // The coolest stay the coolest; new replicas are the hottest.
  std::vector<std::uint32_t> cast(wanted, k_nobody);
  const std::uint64_t scan = retired_;
  for (std::uint32_t level = 0; level < wanted; ++level) {
    const std::uint32_t from_top = wanted - 1 - level;
    if (from_top < old.size()) {
      cast[level] = *flow_.seat(static_cast<std::uint32_t>(old.size()) - 1 - from_top).replica;
      continue;
    }
    // The lowest id that has not lived; from a run store its results may be here already.
    std::uint32_t id = 0;
    while (id < replicas_.size() && replicas_[id].lives)
      ++id;
    if (id == replicas_.size()) replicas_.emplace_back();
    CHECK(replicas_[id].waiting.empty() || replicas_[id].first_scan == scan);
    replicas_[id].first_scan = replicas_[id].next_scan = scan;
    replicas_[id].lives = true;
    cast[level] = id;
  }
  rounds_.push_back(
      {.first_scan = scan,
       .statistics = RoundStatistics(std::move(ladder), options_.round_scans << rounds_.size()),
       .round_trips = 0,
       .restarts = 0,
       .counts = std::vector<KindCounts>(wanted),
       .scales = std::move(scales)});
  flow_ = flow_of(options_, this->ladder());
  rows_.clear();
  for (std::uint32_t level = 0; level < wanted; ++level) {
    flow_.sit(level, cast[level], scan);
    place(cast[level], level, scan);
    ready.push_back(cast[level]);
  }
}

}  // namespace sleight::sampling
