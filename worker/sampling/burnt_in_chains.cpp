#include "worker/sampling/burnt_in_chains.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "common/base/check.h"
#include "worker/sampling/ladder_report.h"

namespace sleight::sampling {

BurntInChains::BurntInChains(const BurntInOptions& options)
    : options_(options),
      burn_in_scans_(options.ladder.anneal_scans +
                     scans_through_round(options.ladder.round_scans, options.burn_in_rounds)),
      order_(options.chains),
      stop_(options.stop, options.ladder.round_scans, burn_in_scans_) {
  CHECK_GE(options.burn_in_rounds, 1U);
  LadderOptions ladder = options.ladder;
  for (std::uint32_t id = 0; id < options.chains; ++id) {
    ladder.chain = base::ChainId{id};
    chains_.push_back({.burn_in = LadderRun(ladder), .part = nullptr, .waiting = {}});
  }
  burning_ = chains_.size();
}

std::optional<plan::Unit> BurntInChains::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  return order_.first({.horizon = stop_.horizon(), .splits = true}, [&](std::size_t id) {
    Chain& chain = chains_[id];
    return chain.part
               ? chain.part->next_unit(stop_.horizon(), scans_max)
               : chain.burn_in.next_unit(std::min(burn_in_scans_, stop_.horizon()), scans_max);
  });
}

std::optional<plan::Block> BurntInChains::next_block(const plan::BlockLimits& limits) {
  const std::uint64_t horizon = stop_.horizon();
  const FurthestBehind::Asked asked{.horizon = horizon, .splits = burning_ < limits.threads};
  return order_.first(asked, [&](std::size_t id) -> std::optional<plan::Block> {
    Chain& chain = chains_[id];
    if (!chain.part)
      return chain.burn_in.next_block(std::min(burn_in_scans_, horizon), limits, burning_);
    auto unit = chain.part->next_unit(horizon, limits.unit_scans_max);
    if (!unit) return std::nullopt;
    return plan::Block{.members = {*std::move(unit)}};
  });
}

void BurntInChains::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                            std::span<const plan::ScanRecord> records) {
  CHECK_LT(replica.chain.value, chains_.size());
  Chain& chain = chains_[replica.chain.value];
  records_ += records.size();
  std::uint64_t first = first_scan.value;
  if (first < burn_in_scans_) {
    const auto early = records.first(
        static_cast<std::size_t>(std::min<std::uint64_t>(records.size(), burn_in_scans_ - first)));
    chain.burn_in.consume(replica.replica, first, early);
    records = records.subspan(early.size());
    first += early.size();
  }
  if (!records.empty()) {
    if (chain.part) {
      chain.part->consume(replica.replica, first, records);
    } else {
      auto& [begin, waiting] = chain.waiting[replica.replica.value];
      if (waiting.empty()) begin = first;
      waiting.insert(waiting.end(), records.begin(), records.end());
    }
  }
  if (!chain.part && chain.burn_in.scans() == burn_in_scans_) begin_part(chain);
  order_.moved(replica.chain.value, chain.scans());
  stop_.judge(order_.least(), [&](std::uint64_t round_end) {
    std::uint64_t solutions = 0;
    for (const Chain& each : chains_)
      solutions += each.part ? each.part->solutions().before(round_end) : 0;
    return solutions;
  });
}

void BurntInChains::begin_part(Chain& chain) {
  chain.part = options_.go_on(chain.burn_in.burn_in());
  --burning_;
  for (const auto& [replica, results] : std::exchange(chain.waiting, {}))
    chain.part->consume(base::ReplicaId{replica}, results.first, results.second);
}

plan::Draws BurntInChains::draws() const {
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  for (const Chain& chain : chains_)
    least = std::min(least, chain.part ? chain.part->draws() : 0);
  return {.first_scan = burn_in_scans_, .count = least};
}

std::uint64_t BurntInChains::solutions_found() const {
  std::uint64_t sum = 0;
  for (const Chain& chain : chains_)
    sum += chain.part ? chain.part->solutions().count() : 0;
  return sum;
}

std::vector<plan::Solution> BurntInChains::solutions_between(std::uint64_t after,
                                                             std::uint64_t until) const {
  std::vector<const Solutions*> chains;
  for (const Chain& chain : chains_)
    chains.push_back(chain.part ? &chain.part->solutions() : nullptr);
  return sampling::solutions_between(chains, after, until);
}

std::vector<plan::EndedRound> BurntInChains::rounds_between(std::uint64_t after,
                                                            std::uint64_t until) const {
  std::vector<plan::EndedRound> all;
  // Exclude the last round, which ladders prepare after the burn-in but never run.
  for (const Chain& chain : chains_)
    std::ranges::copy(chain.burn_in.rounds_between(after, std::min(until, burn_in_scans_)),
                      std::back_inserter(all));
  std::ranges::stable_sort(all, {}, &plan::EndedRound::scans);
  for (plan::EndedRound round : stop_.rounds_between(after, until)) {
    round.round += options_.burn_in_rounds;
    all.push_back(round);
  }
  return all;
}

std::optional<std::uint64_t> BurntInChains::round_trips() const {
  std::uint64_t sum = 0;
  for (const Chain& chain : chains_)
    sum += chain.burn_in.round_trips();
  return sum;
}

plan::Report BurntInChains::report() const {
  std::vector<const LadderRun*> ladders;
  std::vector<std::vector<ChainPart::Row>> rows;
  for (const Chain& chain : chains_) {
    ladders.push_back(&chain.burn_in);
    if (chain.part) rows.push_back(chain.part->rows());
  }
  plan::Report report = report_of(ladders);
  if (rows.size() < chains_.size()) return report;
  report.warning = chains_.front().part->warning();
  for (std::size_t r = 0; r < rows.front().size(); ++r) {
    const ChainPart::Row& first = rows.front()[r];
    const std::string dimension = first.dimension;
    // The width is the length of the longest chain. For draws, it is the smallest number of draws
    // of any chain.
    std::size_t width = 0;
    for (const std::vector<ChainPart::Row>& chain : rows)
      width = std::max(width, chain[r].values.size());
    if (dimension == "draw") width = draws().count;
    plan::Table table{
        .name = first.name, .meaning = first.meaning, .dims = {{"chain", chains_.size()}}};
    if (!dimension.empty()) table.dims.emplace_back(dimension, width);
    for (const std::vector<ChainPart::Row>& chain : rows) {
      std::vector<double> values = chain[r].values;
      values.resize(width, std::numeric_limits<double>::quiet_NaN());
      table.values.insert(table.values.end(), values.begin(), values.end());
    }
    if (width > 0) report.tables.push_back(std::move(table));
  }
  return report;
}

}  // namespace sleight::sampling
