#include "worker/sampling/ladder_report.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "worker/sampling/ladder.h"

namespace sleight::sampling {
namespace {

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

struct Sizes {
  std::size_t ladders = 0;
  std::size_t rounds = 0;
  std::size_t levels = 0;
  std::size_t kinds = 0;
};

/// Returns the rounds that have a scan and begin at `first_scan` or later.
std::span<const RoundReport> begun(const LadderRun& ladder, std::uint64_t first_scan) {
  const std::vector<RoundReport>& rounds = ladder.rounds();
  const bool has_scans = rounds.back().statistics.scans() > 0;
  const auto first = static_cast<std::size_t>(
      std::ranges::lower_bound(rounds, first_scan, {}, &RoundReport::first_scan) - rounds.begin());
  const std::size_t end = rounds.size() - (has_scans ? 0 : 1);
  return std::span(rounds).subspan(std::min(first, end), end - std::min(first, end));
}

Sizes sizes_of(std::span<const LadderRun* const> ladders, std::uint64_t first_scan) {
  Sizes sizes{.ladders = ladders.size()};
  for (const LadderRun* ladder : ladders) {
    sizes.rounds = std::max(sizes.rounds, begun(*ladder, first_scan).size());
    for (const RoundReport& round : begun(*ladder, first_scan)) {
      sizes.levels = std::max(sizes.levels, round.statistics.ladder().size());
      for (const KindCounts& counts : round.counts)
        sizes.kinds = std::max(sizes.kinds, counts.proposed.size());
    }
  }
  return sizes;
}

/// Tables that are filled round by round.
class Tables {
 public:
  Tables(std::span<const LadderRun* const> ladders, std::uint64_t first_scan)
      : ladders_(ladders), first_scan_(first_scan), sizes_(sizes_of(ladders, first_scan)) {}

  bool empty() const { return sizes_.rounds == 0; }
  plan::Report finish() { return std::move(report_); }

  using Scalar = std::function<double(const RoundReport&)>;
  void per_round(std::string name, std::string meaning, const Scalar& value) {
    fill(std::move(name), std::move(meaning), 1, {},
         [&](const RoundReport& round, std::span<double> out) { out[0] = value(round); });
  }
  using Row = std::function<std::vector<double>(const RoundReport&)>;
  void per_level(std::string name, std::string meaning, const Row& values) {
    fill(std::move(name), std::move(meaning), sizes_.levels, {{"level", sizes_.levels}},
         [&](const RoundReport& round, std::span<double> out) {
           std::ranges::copy(values(round), out.begin());
         });
  }
  using Cell = std::function<double(const RoundReport&, std::size_t level, std::size_t kind)>;
  void per_kind(std::string name, std::string meaning, const Cell& value) {
    fill(std::move(name), std::move(meaning), sizes_.levels * sizes_.kinds,
         {{"level", sizes_.levels}, {"proposal_kind", sizes_.kinds}},
         [&](const RoundReport& round, std::span<double> out) {
           for (std::size_t level = 0; level < round.statistics.ladder().size(); ++level) {
             for (std::size_t kind = 0; kind < sizes_.kinds; ++kind)
               out[level * sizes_.kinds + kind] = value(round, level, kind);
           }
         });
  }

 private:
  using Dims = std::vector<std::pair<std::string, std::size_t>>;
  void fill(std::string name, std::string meaning, std::size_t width, const Dims& inner,
            const std::function<void(const RoundReport&, std::span<double>)>& write) {
    plan::Table table{.name = std::move(name),
                      .meaning = std::move(meaning),
                      .dims = {{"chain", sizes_.ladders}, {"round", sizes_.rounds}},
                      .values = std::vector<double>(sizes_.ladders * sizes_.rounds * width, k_nan)};
    table.dims.insert(table.dims.end(), inner.begin(), inner.end());
    for (std::size_t l = 0; l < ladders_.size(); ++l) {
      const std::span<const RoundReport> rounds = begun(*ladders_[l], first_scan_);
      for (std::size_t r = 0; r < rounds.size(); ++r)
        write(rounds[r], std::span(table.values).subspan((l * sizes_.rounds + r) * width, width));
    }
    report_.tables.push_back(std::move(table));
  }

  std::span<const LadderRun* const> ladders_;
  std::uint64_t first_scan_;
  Sizes sizes_;
  plan::Report report_;
};

double per_scan(std::uint64_t count, const RoundReport& round) {
  return static_cast<double>(count) / static_cast<double>(round.statistics.scans());
}

void write_rounds(Tables& tables) {
  tables.per_round("first_scan", "first scan of the round",
                   [](const RoundReport& round) { return static_cast<double>(round.first_scan); });
  tables.per_round("scans", "number of scans in the round", [](const RoundReport& round) {
    return static_cast<double>(round.statistics.scans());
  });
  tables.per_round("levels", "number of temperatures in the ladder", [](const RoundReport& round) {
    return static_cast<double>(round.statistics.ladder().size());
  });
  tables.per_round("barrier", "communication barrier: sum of the rejection rates of swaps",
                   [](const RoundReport& round) {
                     return cumulative_barrier(round.statistics.rejections()).back();
                   });
  tables.per_round("round_trips",
                   "number of round trips from the prior to inverse temperature 1 and back",
                   [](const RoundReport& round) { return static_cast<double>(round.round_trips); });
  tables.per_round("restarts", "number of arrivals at inverse temperature 1 from the prior",
                   [](const RoundReport& round) { return static_cast<double>(round.restarts); });
  tables.per_round("round_trip_rate", "round trips per scan",
                   [](const RoundReport& round) { return per_scan(round.round_trips, round); });
  tables.per_round(
      "predicted_round_trip_rate",
      "round trips per scan predicted from the rejection rates r: 1 / (2 + 2 sum r / (1 - r))",
      [](const RoundReport& round) {
        return predicted_round_trip_rate(round.statistics.rejections());
      });
  tables.per_round(
      "log_z", "log of the mean of the constraint's density under the prior, by stepping stones",
      [](const RoundReport& round) { return round.statistics.log_z().value; });
  tables.per_round("log_z_error", "standard error of log_z, by jackknife",
                   [](const RoundReport& round) { return round.statistics.log_z().error; });
  tables.per_round("log_p_satisfied", "log of the probability that a prior draw satisfies",
                   [](const RoundReport& round) { return round.statistics.log_satisfied().value; });
  tables.per_round("log_p_satisfied_error", "standard error of log_p_satisfied, by jackknife",
                   [](const RoundReport& round) { return round.statistics.log_satisfied().error; });
}

void write_levels(Tables& tables) {
  tables.per_level("inverse_temperature", "exponent of the constraint's density at the level",
                   [](const RoundReport& round) { return round.statistics.ladder(); });
  tables.per_level("swap_acceptance", "mean swap probability with the next cooler level",
                   [](const RoundReport& round) {
                     std::vector<double> rates = round.statistics.rejections();
                     for (double& rate : rates)
                       rate = 1 - rate;
                     return rates;
                   });
  tables.per_level("local_barrier", "derivative of the barrier with respect to inverse temperature",
                   [](const RoundReport& round) {
                     return local_barrier(round.statistics.ladder(), round.statistics.rejections());
                   });
  tables.per_kind("acceptance", "accepted share of proposals, by level and kind",
                  [](const RoundReport& round, std::size_t level, std::size_t kind) {
                    const KindCounts& counts = round.counts[level];
                    if (kind >= counts.proposed.size()) return k_nan;
                    return static_cast<double>(counts.accepted[kind]) /
                           static_cast<double>(counts.proposed[kind]);
                  });
  tables.per_kind("proposal_scale", "scale factor of the proposals' step sizes, by level and kind",
                  [](const RoundReport& round, std::size_t level, std::size_t kind) {
                    const std::vector<double>& scales = round.scales[level];
                    return kind < scales.size() ? scales[kind] : 1.0;
                  });
}

/// Returns the moments of the index process from `first_scan` on.
std::span<const IndexProcess::Moment> moments_from(const LadderRun& ladder,
                                                   std::uint64_t first_scan) {
  const std::vector<IndexProcess::Moment>& all = ladder.index_process().moments();
  const auto first = std::ranges::lower_bound(all, first_scan, {}, &IndexProcess::Moment::scan);
  return {first, all.end()};
}

/// Adds each replica's level to the report, for a limited number of scans.
void add_index_process(std::span<const LadderRun* const> ladders, std::uint64_t first_scan,
                       plan::Report& report) {
  std::size_t moments = 0;
  std::size_t replicas = 0;
  for (const LadderRun* ladder : ladders) {
    const auto of_ladder = moments_from(*ladder, first_scan);
    moments = std::max(moments, of_ladder.size());
    for (const IndexProcess::Moment& moment : of_ladder)
      replicas = std::max(replicas, moment.level.size());
  }
  if (moments == 0) return;
  const std::pair<std::string, std::size_t> by_chain{"chain", ladders.size()};
  const std::pair<std::string, std::size_t> by_moment{"moment", moments};
  plan::Table scans{.name = "index_scan",
                    .meaning = "scan at which the replicas' levels were recorded",
                    .dims = {by_chain, by_moment},
                    .values = std::vector<double>(ladders.size() * moments, k_nan)};
  plan::Table levels{.name = "index_level",
                     .meaning = "level of the replica; level 0 is the prior",
                     .dims = {by_chain, by_moment, {"replica", replicas}},
                     .values = std::vector<double>(ladders.size() * moments * replicas, k_nan)};
  for (std::size_t l = 0; l < ladders.size(); ++l) {
    std::size_t row = l * moments;
    for (const IndexProcess::Moment& moment : moments_from(*ladders[l], first_scan)) {
      scans.values[row] = static_cast<double>(moment.scan);
      for (std::size_t replica = 0; replica < moment.level.size(); ++replica) {
        if (moment.level[replica] != IndexProcess::k_no_level)
          levels.values[row * replicas + replica] = moment.level[replica];
      }
      ++row;
    }
  }
  report.tables.push_back(std::move(scans));
  report.tables.push_back(std::move(levels));
}

}  // namespace

plan::Report report_of(std::span<const LadderRun* const> ladders, std::uint64_t burnt_in_at) {
  Tables tables(ladders, burnt_in_at);
  if (tables.empty()) return {};
  write_rounds(tables);
  write_levels(tables);
  plan::Report report = tables.finish();
  add_index_process(ladders, burnt_in_at, report);
  return report;
}

}  // namespace sleight::sampling
