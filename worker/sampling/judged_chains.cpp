#include "worker/sampling/judged_chains.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "common/base/check.h"
#include "common/random/discrete_distributions.h"

namespace sleight::sampling {
namespace {

constexpr std::uint64_t k_no_end = std::numeric_limits<std::uint64_t>::max();
/// Maximum number of times that a tour's rounds double. Later rounds keep the last length.
constexpr std::uint32_t k_doublings_max = 24;

}  // namespace

JudgedChains::JudgedChains(JudgedChainsOptions options)
    : options_(std::move(options)),
      chains_(options_.chains),
      behind_(options_.chains),
      end_(options_.scans.value_or(k_no_end)) {
  CHECK_GE(options_.chains, 2U);
  CHECK_GE(options_.round_scans, 4U);
  CHECK(options_.scans || options_.independent_solutions);
  for (Chain& chain : chains_)
    chain.values.resize(options_.judged.size());
}

std::optional<plan::Unit> JudgedChains::next_unit(std::uint32_t scans_max) {
  CHECK_GE(scans_max, 1U);
  const std::uint64_t horizon = std::min(end_, round_begin_ + round_length());
  return behind_.first({.horizon = horizon}, [&](std::size_t id) -> std::optional<plan::Unit> {
    Chain& chain = chains_[id];
    if (chain.is_out || chain.consumed >= horizon) return std::nullopt;
    chain.is_out = true;
    const std::uint64_t scans = std::min<std::uint64_t>(horizon - chain.consumed, scans_max);
    return plan::Unit{
        .replica = {base::ChainId{static_cast<std::uint32_t>(id)}, base::ReplicaId{0}},
        .seed = options_.seed,
        .first_scan = base::ScanIndex{chain.consumed},
        .scans = static_cast<std::uint32_t>(scans),
        .starts = chain.consumed == tour_begin_,
        .lineage = plan::lineage_from(base::ReplicaId{0}, tour_begin_)};
  });
}

void JudgedChains::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                           std::span<const plan::ScanRecord> records) {
  CHECK_LT(replica.chain.value, chains_.size());
  Chain& chain = chains_[replica.chain.value];
  CHECK_EQ(first_scan.value, chain.consumed);
  for (const plan::ScanRecord& record : records) {
    CHECK_EQ(record.method_values.size(), options_.judged.size());
    for (std::size_t value = 0; value < options_.judged.size(); ++value)
      chain.values[value].push_back(record.method_values[value]);
    chain.satisfied.push_back(record.satisfied);
    chain.log_ps.push_back(record.log_prior + record.log_constraint);
  }
  chain.consumed += records.size();
  chain.is_out = false;
  behind_.moved(replica.chain.value, chain.consumed);
  judge_rounds();
}

void JudgedChains::judge_rounds() {
  while (round_begin_ + round_length() <= std::min(behind_.least(), end_)) {
    const std::uint64_t round_end = round_begin_ + round_length();
    std::optional<Tour> tour = burnt_in();
    round_begin_ = round_end;
    round_ends_.push_back(round_end);
    round_ = std::min(round_ + 1, k_doublings_max);
    if (!tour) continue;
    for (const auto& counted : tour->counted)
      solutions_ += counted ? 1 : 0;
    tours_.push_back(*std::move(tour));
    if (options_.independent_solutions && solutions_ >= *options_.independent_solutions)
      end_ = std::min(end_, round_end);

    // Begin the next tour. A run store may already have delivered the next tour's first values.
    for (Chain& chain : chains_) {
      const auto done = static_cast<std::ptrdiff_t>(round_end - tour_begin_);
      for (auto& values : chain.values)
        values.erase(values.begin(), values.begin() + done);
      chain.satisfied.erase(chain.satisfied.begin(), chain.satisfied.begin() + done);
      chain.log_ps.erase(chain.log_ps.begin(), chain.log_ps.begin() + done);
    }
    tour_begin_ = round_end;
    round_ = 0;
  }
}

std::optional<JudgedChains::Tour> JudgedChains::burnt_in() const {
  Tour tour{.begin = tour_begin_,
            .judged_from = round_begin_,
            .end = round_begin_ + round_length(),
            .r_hats = {},
            .counted = {},
            .log_ps = {}};
  const std::size_t first = tour.judged_from - tour.begin;
  const std::size_t count = tour.end - tour.judged_from;
  bool passes = round_ > 0;  // A first round has no burn-in before it.
  for (std::size_t value = 0; value < options_.judged.size(); ++value) {
    OwnedChains draws{.values = {}, .chains = chains_.size(), .draws = count};
    for (const Chain& chain : chains_) {
      const auto begin = chain.values[value].begin() + static_cast<std::ptrdiff_t>(first);
      draws.values.insert(draws.values.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
    }
    std::vector<double> starts;
    for (const Chain& chain : chains_)
      starts.push_back(chain.values[value].front());
    const ValueVerdict verdict = judge_value(options_.judged[value], starts, draws.view());
    tour.r_hats.push_back(verdict.r_hat);
    passes = passes && verdict.passes;
  }
  if (!passes) return std::nullopt;
  tour.counted = solutions_of(tour.judged_from, tour.end);
  for (std::size_t id = 0; id < chains_.size(); ++id)
    tour.log_ps.push_back(tour.counted[id] ? chains_[id].log_ps[*tour.counted[id] - tour.begin]
                                           : 0);
  return tour;
}

std::vector<std::optional<std::uint64_t>> JudgedChains::solutions_of(std::uint64_t judged_from,
                                                                     std::uint64_t end) const {
  std::vector<std::optional<std::uint64_t>> counted(chains_.size());
  for (std::uint32_t id = 0; id < chains_.size(); ++id) {
    std::vector<std::uint64_t> satisfied;
    for (std::uint64_t scan = judged_from; scan < end; ++scan)
      if (chains_[id].satisfied[scan - tour_begin_]) satisfied.push_back(scan);
    if (satisfied.empty()) continue;
    random::Stream stream(
        {.seed = options_.seed, .chain = base::ChainId{id}, .purpose = random::Purpose::counted},
        judged_from);
    counted[id] = satisfied[random::UniformInteger{.count = satisfied.size()}.draw(stream)];
  }
  return counted;
}

plan::Draws JudgedChains::draws() const {
  plan::Draws draws{.first_scan = tours_.empty() ? scans_common() : tours_.front().judged_from};
  for (const Tour& tour : tours_) {
    draws.parts.push_back({.first_scan = tour.judged_from,
                           .count = tour.end - tour.judged_from,
                           .counted = tour.counted});
    draws.count += draws.parts.back().count;
  }
  return draws;
}

std::vector<plan::Solution> JudgedChains::solutions_between(std::uint64_t after,
                                                            std::uint64_t until) const {
  std::vector<plan::Solution> all;
  const auto first = std::ranges::upper_bound(tours_, after, {}, &Tour::end);
  for (auto tour = first; tour != tours_.end() && tour->end <= until; ++tour) {
    for (std::uint32_t id = 0; id < tour->counted.size(); ++id) {
      if (!tour->counted[id]) continue;
      all.push_back({.chain = base::ChainId{id},
                     .scan = *tour->counted[id],
                     .log_p = tour->log_ps[id],
                     .decided = tour->end});
    }
  }
  return all;
}

std::vector<plan::EndedRound> JudgedChains::rounds_between(std::uint64_t after,
                                                           std::uint64_t until) const {
  std::vector<plan::EndedRound> all;
  for (auto end = std::ranges::upper_bound(round_ends_, after);
       end != round_ends_.end() && *end <= until; ++end)
    all.push_back(
        {.round = static_cast<std::uint64_t>(end - round_ends_.begin()) + 1, .scans = *end});
  return all;
}

std::optional<std::uint64_t> JudgedChains::scans_total() const {
  if (end_ == k_no_end) return std::nullopt;
  return end_ * chains_.size();
}

plan::Report JudgedChains::report() const {
  if (tours_.empty()) return {};
  plan::Report report;
  // All chains share their tours, so each chain's row is the same.
  const auto add =
      [&](const char* name, const char* meaning, std::size_t values,
          const std::function<double(const Tour&, std::size_t chain, std::size_t value)>& number) {
        plan::Table table{.name = name,
                          .meaning = meaning,
                          .dims = {{"chain", chains_.size()}, {"tour", tours_.size()}}};
        if (values > 1) table.dims.emplace_back("judged_value", values);
        for (std::size_t chain = 0; chain < chains_.size(); ++chain)
          for (const Tour& tour : tours_)
            for (std::size_t value = 0; value < values; ++value)
              table.values.push_back(number(tour, chain, value));
        report.tables.push_back(std::move(table));
      };
  add("tour_begin", "scan at which all chains restarted from a search", 1,
      [](const Tour& tour, std::size_t, std::size_t) { return static_cast<double>(tour.begin); });
  add("tour_judged_from", "the tour's first scan that is a draw", 1,
      [](const Tour& tour, std::size_t, std::size_t) {
        return static_cast<double>(tour.judged_from);
      });
  add("tour_end", "number of the scan that follows the tour's last scan", 1,
      [](const Tour& tour, std::size_t, std::size_t) { return static_cast<double>(tour.end); });
  add("tour_r_hat",
      "split R-hat of the quantity that judges the burn-in; NaN if that quantity is constant",
      options_.judged.size(),
      [](const Tour& tour, std::size_t, std::size_t value) { return tour.r_hats[value]; });
  add("counted_scan", "scan of the chain's independent solution; NaN if none", 1,
      [](const Tour& tour, std::size_t chain, std::size_t) {
        return tour.counted[chain] ? static_cast<double>(*tour.counted[chain])
                                   : std::numeric_limits<double>::quiet_NaN();
      });
  return report;
}

}  // namespace sleight::sampling
