#include "worker/sampling/restarted_chains.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_no_end = std::numeric_limits<std::uint64_t>::max();

}  // namespace

RestartedChains::RestartedChains(const RestartedChainsOptions& options)
    : options_(options),
      chains_(options.chains),
      behind_(options.chains),
      end_(options.scans.value_or(k_no_end)) {
  CHECK_GE(options.tour_scans, 2U);
  CHECK(options.scans || options.independent_solutions);
}

std::optional<plan::Unit> RestartedChains::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  // Once all chains have ended the current tour, the run decides whether it needs another tour.
  const std::uint64_t horizon =
      options_.independent_solutions ? std::min(end_, end_of_tour(tours_)) : end_;
  return behind_.first({.horizon = horizon}, [&](std::size_t id) -> std::optional<plan::Unit> {
    Chain& chain = chains_[id];
    if (chain.is_out || chain.consumed >= horizon) return std::nullopt;
    chain.is_out = true;
    const std::uint64_t done_of_tour = chain.consumed % options_.tour_scans;
    const std::uint64_t scans = std::min(
        {options_.tour_scans - done_of_tour, horizon - chain.consumed, std::uint64_t{scans_max}});
    return plan::Unit{
        .replica = {base::ChainId{static_cast<std::uint32_t>(id)}, base::ReplicaId{0}},
        .seed = options_.seed,
        .first_scan = base::ScanIndex{chain.consumed},
        .scans = static_cast<std::uint32_t>(scans),
        .starts = done_of_tour == 0,
        .lineage = chain.lineage};
  });
}

void RestartedChains::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                              std::span<const plan::ScanRecord> records) {
  CHECK_LT(replica.chain.value, chains_.size());
  Chain& chain = chains_[replica.chain.value];
  CHECK_EQ(first_scan.value, chain.consumed);
  for (const plan::ScanRecord& record : records) {
    chain.islands.add(record);
    chain.lineage = record.lineage;
    ++chain.consumed;
    if (chain.consumed % options_.tour_scans != 0) continue;
    chain.satisfied.push_back(record.satisfied);
    chain.log_ps.push_back(record.log_prior + record.log_constraint);
  }
  chain.is_out = false;
  behind_.moved(replica.chain.value, chain.consumed);
  judge_tours();
}

void RestartedChains::judge_tours() {
  while (end_of_tour(tours_) <= std::min(behind_.least(), end_)) {
    for (const Chain& chain : chains_)
      solutions_ += chain.satisfied[tours_] ? 1 : 0;
    ++tours_;
    if (options_.independent_solutions && solutions_ >= *options_.independent_solutions)
      end_ = std::min(end_, tours_ * options_.tour_scans);
  }
}

plan::Draws RestartedChains::draws() const {
  plan::Draws draws{.first_scan = options_.tour_scans - 1, .count = tours_};
  for (std::uint64_t tour = 0; tour < tours_; ++tour) {
    const std::uint64_t last_scan = end_of_tour(tour) - 1;
    std::vector<std::optional<std::uint64_t>> counted(chains_.size());
    for (std::size_t id = 0; id < chains_.size(); ++id)
      if (chains_[id].satisfied[tour]) counted[id] = last_scan;
    draws.parts.push_back({.first_scan = last_scan, .count = 1, .counted = std::move(counted)});
  }
  return draws;
}

std::vector<plan::Solution> RestartedChains::solutions_between(std::uint64_t after,
                                                               std::uint64_t until) const {
  std::vector<plan::Solution> all;
  const std::uint64_t end = std::min(tours_, until / options_.tour_scans);
  for (std::uint64_t tour = after / options_.tour_scans; tour < end; ++tour) {
    for (std::uint32_t id = 0; id < chains_.size(); ++id) {
      if (!chains_[id].satisfied[tour]) continue;
      all.push_back({.chain = base::ChainId{id},
                     .scan = end_of_tour(tour) - 1,
                     .log_p = chains_[id].log_ps[tour],
                     .decided = end_of_tour(tour)});
    }
  }
  return all;
}

std::optional<std::uint64_t> RestartedChains::scans_total() const {
  if (end_ == k_no_end) return std::nullopt;
  return end_ * chains_.size();
}

plan::Report RestartedChains::report() const {
  std::vector<const IslandsOfChain*> islands;
  for (const Chain& chain : chains_)
    islands.push_back(&chain.islands);
  // Islands affect solutions, which decide whether there are tours after the first.
  const bool can_end_early = options_.independent_solutions.has_value();
  const std::uint64_t in_any_case = std::min(end_of_tour(0), options_.scans.value_or(k_no_end));
  const bool are_there = can_end_early && scans_common() >= in_any_case;
  return report_of(islands, scans_common(),
                   {.end = are_there ? std::optional(in_any_case) : std::nullopt});
}

}  // namespace sleight::sampling
