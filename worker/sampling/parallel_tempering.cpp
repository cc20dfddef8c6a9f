#include "worker/sampling/parallel_tempering.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "worker/sampling/furthest_behind.h"
#include "worker/sampling/ladder.h"
#include "worker/sampling/ladder_report.h"

namespace sleight::sampling {

ParallelTempering::ParallelTempering(const ParallelTemperingOptions& options)
    : anneal_scans_(options.ladder.anneal_scans),
      stop_(options.stop, options.ladder.round_scans, options.ladder.anneal_scans) {
  CHECK_GE(options.ladders, 1U);
  LadderOptions ladder = options.ladder;
  for (std::uint32_t id = 0; id < options.ladders; ++id) {
    ladder.chain = base::ChainId{id};
    ladders_.emplace_back(ladder);
  }
}

std::optional<plan::Unit> ParallelTempering::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  return next_of_furthest_behind(
      ladders_, [&](LadderRun& ladder) { return ladder.next_unit(stop_.horizon(), scans_max); });
}

std::optional<plan::Block> ParallelTempering::next_block(const plan::BlockLimits& limits) {
  const auto goes_on = [&](const LadderRun& ladder) { return ladder.scans() < stop_.horizon(); };
  const auto going = static_cast<std::size_t>(std::ranges::count_if(ladders_, goes_on));
  return next_of_furthest_behind(ladders_, [&](LadderRun& ladder) {
    return ladder.next_block(stop_.horizon(), limits, going);
  });
}

void ParallelTempering::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                                std::span<const plan::ScanRecord> records) {
  CHECK_LT(replica.chain.value, ladders_.size());
  ladders_[replica.chain.value].consume(replica.replica, first_scan.value, records);
  stop_.judge(reached_by_all(), [&](std::uint64_t round_end) {
    std::uint64_t solutions = 0;
    for (const LadderRun& ladder : ladders_)
      solutions += ladder.solutions().before(round_end);
    return solutions;
  });
}

bool ParallelTempering::finished() const {
  return std::ranges::all_of(
      ladders_, [&](const LadderRun& ladder) { return ladder.scans() >= stop_.end(); });
}

std::uint64_t ParallelTempering::reached_by_all() const {
  return std::ranges::min_element(ladders_, {}, &LadderRun::scans)->scans();
}

std::uint64_t ParallelTempering::scans_common() const {
  return std::min(reached_by_all(), stop_.end());
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
