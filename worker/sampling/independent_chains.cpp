#include "worker/sampling/independent_chains.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "worker/sampling/ladder.h"

namespace sleight::sampling {

IndependentChains::IndependentChains(const IndependentChainsOptions& options)
    : seed_(options.seed),
      anneal_scans_(options.anneal_scans),
      scans_before_draws_(options.anneal_scans + options.burn_in_scans),
      has_islands_(options.has_islands),
      chains_(options.chains),
      behind_(options.chains),
      stop_(options.stop, options.round_scans, scans_before_draws_) {}

std::optional<plan::Unit> IndependentChains::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  const std::uint64_t horizon = stop_.horizon();
  return behind_.first({.horizon = horizon}, [&](std::size_t id) -> std::optional<plan::Unit> {
    Chain& chain = chains_[id];
    if (chain.is_out || chain.consumed >= horizon) return std::nullopt;
    chain.is_out = true;
    std::uint64_t scans = std::min<std::uint64_t>(horizon - chain.consumed, scans_max);
    std::vector<double> betas{1};
    if (chain.consumed < anneal_scans_) {
      scans = std::min(scans, anneal_scans_ - chain.consumed);
      betas = annealing(1, anneal_scans_, chain.consumed, scans);
    }
    return plan::Unit{
        .replica = {base::ChainId{static_cast<std::uint32_t>(id)}, base::ReplicaId{0}},
        .seed = seed_,
        .first_scan = base::ScanIndex{chain.consumed},
        .scans = static_cast<std::uint32_t>(scans),
        .starts = chain.consumed == 0,
        .lineage = chain.lineage,
        .inverse_temperatures = std::move(betas)};
  });
}

plan::Draws IndependentChains::draws() const {
  const std::uint64_t scans = scans_common();
  return {.first_scan = scans_before_draws_, .count = scans - std::min(scans, scans_before_draws_)};
}

/// Plain chains count solutions from their start. Lineages that began in a burn-in don't count.
bool IndependentChains::counts(const plan::ScanRecord& record, std::uint64_t scan) const {
  if (scans_before_draws_ == anneal_scans_) return true;
  return scan >= scans_before_draws_ &&
         plan::scan_of_lineage(record.lineage) >= scans_before_draws_;
}

void IndependentChains::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                                std::span<const plan::ScanRecord> records) {
  CHECK_LT(replica.chain.value, chains_.size());
  CHECK_EQ(replica.replica.value, 0U);
  Chain& chain = chains_[replica.chain.value];
  CHECK_EQ(first_scan.value, chain.consumed);
  for (const plan::ScanRecord& record : records) {
    if (counts(record, chain.consumed)) chain.solutions.add(chain.consumed, record);
    if (has_islands_) chain.islands.add(record);
    chain.lineage = record.lineage;
    ++chain.consumed;
  }
  chain.is_out = false;
  behind_.moved(replica.chain.value, chain.consumed);
  stop_.judge(behind_.least(), [this](std::uint64_t round_end) {
    std::uint64_t solutions = 0;
    for (const Chain& each : chains_)
      solutions += each.solutions.before(round_end);
    return solutions;
  });
}

std::uint64_t IndependentChains::solutions_found() const {
  std::uint64_t sum = 0;
  for (const Chain& chain : chains_)
    sum += chain.solutions.count();
  return sum;
}

std::vector<plan::Solution> IndependentChains::solutions_between(std::uint64_t after,
                                                                 std::uint64_t until) const {
  std::vector<const Solutions*> chains;
  for (const Chain& chain : chains_)
    chains.push_back(&chain.solutions);
  return sampling::solutions_between(chains, after, until);
}

plan::Report IndependentChains::report() const {
  if (!has_islands_) return {};
  std::vector<const IslandsOfChain*> islands;
  for (const Chain& chain : chains_)
    islands.push_back(&chain.islands);
  const auto in_any_case = stop_.scans_in_any_case();
  const bool are_there = in_any_case && scans_common() >= *in_any_case;
  return report_of(islands, scans_common(), {.end = are_there ? in_any_case : std::nullopt});
}

std::optional<std::uint64_t> IndependentChains::scans_total() const {
  if (stop_.end() == StopJudge::k_no_end) return std::nullopt;
  return stop_.end() * chains_.size();
}

}  // namespace sleight::sampling
