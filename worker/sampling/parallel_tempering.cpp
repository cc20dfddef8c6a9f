#include "worker/sampling/parallel_tempering.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/ladder_report.h"

namespace sleight::sampling {

ParallelTempering::ParallelTempering(const ParallelTemperingOptions& options)
    : anneal_scans_(options.ladder.anneal_scans),
      order_(options.ladders),
      stop_(options.stop, options.ladder.round_scans, options.ladder.anneal_scans) {
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
  stop_.judge(order_.least(), [&](std::uint64_t round_end) {
    std::uint64_t solutions = 0;
    for (const LadderRun& ladder : ladders_)
      solutions += ladder.solutions().before(round_end);
    return solutions;
  });
}

bool ParallelTempering::finished() const {
  return order_.least() >= stop_.end();
}

std::uint64_t ParallelTempering::scans_common() const {
  return std::min(order_.least(), stop_.end());
}

plan::Draws ParallelTempering::draws() const {
  const std::uint64_t scans = scans_common();
  return {.first_scan = anneal_scans_, .count = scans - std::min(scans, anneal_scans_)};
}

std::uint64_t ParallelTempering::solutions_found() const {
  std::uint64_t sum = 0;
  for (const LadderRun& ladder : ladders_)
    sum += ladder.solutions().count();
  return sum;
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
  return report_of(ladders);
}

}  // namespace sleight::sampling
