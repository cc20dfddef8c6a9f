#include "worker/sampling/island_report.h"

#include <functional>
#include <utility>

#include "common/base/check.h"

namespace sleight::sampling {

void IslandsOfChain::add(const plan::ScanRecord& record) {
  const std::span<const double> values = record.method_values;
  CHECK_EQ(values.size() % IslandEstimate::k_values, 0U);
  for (std::size_t i = 0; i < values.size(); i += IslandEstimate::k_values)
    estimates_.push_back(IslandEstimate::of(values.subspan(i, IslandEstimate::k_values)));
  ends_.push_back(estimates_.size());
}

void IslandsOfChain::add(const IslandEstimate& island) {
  estimates_.push_back(island);
  ends_.push_back(estimates_.size());
}

plan::Report report_of(std::span<const IslandsOfChain* const> chains, std::uint64_t scans,
                       const OddsScans& odds) {
  std::size_t islands = chains.empty() ? 0 : chains.front()->count_of(scans);
  if (islands == 0) return {};
  plan::Report report;
  using Value = std::function<double(const IslandEstimate&)>;
  const auto add = [&](const char* name, const char* meaning, const Value& value) {
    plan::Table table{
        .name = name, .meaning = meaning, .dims = {{"chain", chains.size()}, {"island", islands}}};
    for (const IslandsOfChain* chain : chains) {
      CHECK_EQ(chain->count_of(scans), islands);
      for (std::size_t i = 0; i < islands; ++i)
        table.values.push_back(value(chain->estimates()[i]));
    }
    report.tables.push_back(std::move(table));
  };
  add("island_log_z", "log of the island's unbiased estimate of Z, the integral of p_w p_c",
      [](const IslandEstimate& island) { return island.log_z; });
  add("island_log_satisfied", "log of the island's unbiased estimate of P(satisfied)",
      [](const IslandEstimate& island) { return island.log_satisfied; });
  add("island_effective_size", "effective sample size of the island's particles",
      [](const IslandEstimate& island) { return island.effective_size; });
  add("island_accepted", "1 if the chain accepted the island's draw, else 0",
      [](const IslandEstimate& island) { return island.accepted ? 1.0 : 0.0; });
  const auto add_number = [&](const char* name, const char* meaning, std::uint64_t of_scan) {
    CHECK_LE(of_scan, scans);
    plan::Table table{.name = name, .meaning = meaning, .dims = {{"chain", chains.size()}}};
    for (const IslandsOfChain* chain : chains)
      table.values.push_back(static_cast<double>(chain->count_of(of_scan)));
    report.tables.push_back(std::move(table));
  };
  if (odds.first) {
    add_number("odds_from_island",
               "number of the first island used for the odds; the chain's earlier islands were "
               "used to choose the number of islands",
               *odds.first);
  }
  if (odds.end) {
    add_number("odds_until_island",
               "number of islands used for the odds, counted from the chain's first island",
               *odds.end);
  }
  return report;
}

}  // namespace sleight::sampling
