#include "worker/sampling/parallel_tempering.h"

#include <algorithm>
#include <iterator>
#include <limits>

#include "common/base/check.h"
#include "worker/sampling/ladder_report.h"

namespace sleight::sampling {

ParallelTempering::ParallelTempering(const ParallelTemperingOptions& options)
    : anneal_scans_(options.ladder.anneal_scans),
      round_scans_(options.ladder.round_scans),
      starts_by_search_(options.ladder.starts_by_search),
      order_(options.ladders),
      stop_(options.stop, options.ladder.round_scans, options.ladder.anneal_scans) {
  CHECK(!starts_by_search_ || anneal_scans_ == 0);
  if (!starts_by_search_) burnt_in_at_ = anneal_scans_;
  LadderOptions ladder = options.ladder;
  for (std::uint32_t id = 0; id < options.ladders; ++id) {
    ladder.chain = base::ChainId{id};
    ladders_.emplace_back(ladder);
  }
}

std::optional<plan::Unit> ParallelTempering::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  return order_.first({.horizon = stop_.horizon(), .splits = true}, [&](std::size_t ladder) {
    return ladders_[ladder].next_unit(stop_.horizon(), scans_max);
  });
}

std::optional<plan::Block> ParallelTempering::next_block(const plan::BlockLimits& limits) {
  const std::uint64_t horizon = stop_.horizon();
  const std::size_t going = order_.going(horizon);
  const bool splits = going < limits.threads;
  return order_.first({.horizon = horizon, .splits = splits}, [&](std::size_t ladder) {
    return ladders_[ladder].next_block(horizon, limits, going);
  });
}

void ParallelTempering::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                                std::span<const plan::ScanRecord> records) {
  CHECK_LT(replica.chain.value, ladders_.size());
  LadderRun& consumer = ladders_[replica.chain.value];
  consumer.consume(replica.replica, first_scan.value, records);
  order_.moved(replica.chain.value, consumer.scans());
  judge_burn_in();
  stop_.judge(order_.least(),
              [this](std::uint64_t round_end) { return solutions_before(round_end); });
}

void ParallelTempering::judge_burn_in() {
  while (!burnt_in_at_) {
    const std::uint64_t round_end = scans_through_round(round_scans_, rounds_judged_ + 1);
    if (round_end > order_.least()) return;
    ++rounds_judged_;
    const bool all_are_clean = std::ranges::all_of(
        ladders_, [&](const LadderRun& ladder) { return ladder.searched_until() < round_end; });
    if (all_are_clean) burnt_in_at_ = round_end;
  }
}

std::uint64_t ParallelTempering::solutions_before(std::uint64_t scan) const {
  if (!burnt_in_at_) return 0;
  std::uint64_t sum = 0;
  for (const LadderRun& ladder : ladders_)
    sum += solutions_of(ladder).before(scan);
  return sum;
}

const Solutions& ParallelTempering::solutions_of(const LadderRun& ladder) const {
  return starts_by_search_ ? ladder.solutions_since(*burnt_in_at_) : ladder.solutions();
}

std::vector<plan::Solution> ParallelTempering::solutions_between(std::uint64_t after,
                                                                 std::uint64_t until) const {
  if (!burnt_in_at_) return {};
  std::vector<const Solutions*> chains;
  for (const LadderRun& ladder : ladders_)
    chains.push_back(&solutions_of(ladder));
  return sampling::solutions_between(chains, after, until);
}

std::vector<plan::EndedRound> ParallelTempering::rounds_between(std::uint64_t after,
                                                                std::uint64_t until) const {
  std::vector<plan::EndedRound> all;
  for (const LadderRun& ladder : ladders_)
    std::ranges::copy(ladder.rounds_between(after, until), std::back_inserter(all));
  std::ranges::stable_sort(all, {}, &plan::EndedRound::scans);
  return all;
}

plan::Draws ParallelTempering::draws() const {
  const std::uint64_t scans = scans_common();
  std::uint64_t first_scan = burnt_in_at_.value_or(scans);
  if (starts_by_search_) first_scan = std::min(first_scan, scans);
  return {.first_scan = first_scan, .count = scans - std::min(scans, first_scan)};
}

std::uint64_t ParallelTempering::solutions_found() const {
  return solutions_before(std::numeric_limits<std::uint64_t>::max());
}

std::uint64_t ParallelTempering::scans_consumed() const {
  std::uint64_t sum = 0;
  for (const LadderRun& ladder : ladders_)
    sum += ladder.records_consumed();
  return sum;
}

std::optional<std::uint64_t> ParallelTempering::scans_total() const {
  if (stop_.end() == StopJudge::k_no_end) return std::nullopt;
  std::uint64_t sum = 0;
  for (const LadderRun& ladder : ladders_) {
    sum += ladder.records_counted();
    const std::uint64_t levels = ladder.rounds().back().statistics.ladder().size();
    if (ladder.scans() < stop_.end()) sum += levels * (stop_.end() - ladder.scans());
  }
  return sum;
}

std::optional<std::uint64_t> ParallelTempering::round_trips() const {
  std::uint64_t sum = 0;
  for (const LadderRun& ladder : ladders_)
    sum += ladder.round_trips();
  return sum;
}

plan::Report ParallelTempering::report() const {
  std::vector<const LadderRun*> ladders;
  for (const LadderRun& ladder : ladders_)
    ladders.push_back(&ladder);
  return report_of(ladders, starts_by_search_ ? burnt_in_at_.value_or(scans_common()) : 0);
}

}  // namespace sleight::sampling
