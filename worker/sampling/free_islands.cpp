#include "worker/sampling/free_islands.h"

#include <cmath>
#include <limits>
#include <string>

#include "common/base/check.h"

namespace sleight::sampling {

FreeIslands::FreeIslands(const FreeIslandsOptions& options)
    : lanes_(plan::k_first_island_lane, plan::k_island_lanes, options.seed),
      islands_max_(options.islands_max.value_or(std::numeric_limits<std::uint64_t>::max())),
      rule_(options.log_error) {}

std::optional<plan::Unit> FreeIslands::next_unit(std::uint32_t scans_max) {
  if (finished()) return std::nullopt;
  return lanes_.next_unit(end(), scans_max);
}

void FreeIslands::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                          std::span<const plan::ScanRecord> records) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    CHECK_EQ(records[i].method_values.size(), IslandEstimate::k_values);
    ahead_.emplace(plan::island_number(replica.chain, first_scan.value + i),
                   IslandEstimate::of(records[i].method_values));
  }
  lanes_.consume(replica.chain, first_scan, records.size());
  // If a run store was written under another stop rule, it may have islands beyond the end; ignore
  // them.
  while (!finished() && scans_common() < lanes_.done()) {
    const auto next = ahead_.extract(scans_common());
    CHECK(!next.empty());
    islands_.add(next.mapped());
    rule_.add(next.mapped().log_satisfied);
  }
}

std::optional<std::uint64_t> FreeIslands::scans_total() const {
  if (!rule_.is_sized() && !rule_.is_over()) return std::nullopt;
  return end();
}

plan::Odds FreeIslands::odds() const {
  const math::IslandOdds odds = rule_.odds();
  const auto finite = [](double x) { return std::isfinite(x) ? std::optional(x) : std::nullopt; };
  const bool is_final = rule_.is_over() && odds.known();
  return {.are_asked = true,
          .islands = is_final ? odds.islands : scans_common(),
          .wanted = scans_total().value_or(0),
          .log_p = finite(odds.log_mean),
          .log_error = finite(odds.log_error()),
          .is_final = is_final};
}

plan::Report FreeIslands::report() const {
  const std::uint64_t islands = scans_common();
  if (islands == 0) return {};
  const IslandsOfChain* const chains[] = {&islands_};
  const bool is_complete = rule_.is_over() && rule_.is_sized();
  plan::Report report =
      report_of(chains, islands,
                {.first = is_complete ? std::optional(rule_.pilot_islands()) : std::nullopt});
  plan::Table weights{.name = "log_weight",
                      .meaning = "log weight of the draw",
                      .dims = {{"chain", 1}, {"draw", islands}},
                      .values = {}};
  for (const IslandEstimate& island : islands_.estimates())
    weights.values.push_back(island.log_z);
  report.tables.push_back(std::move(weights));
  report.warning =
      std::string("draws are weighted; their log weights are in /tempering/log_weight");
  return report;
}

}  // namespace sleight::sampling
