// A Plan that makes only free islands. Runs that request only the odds use it. Islands share
// nothing, so any number of workers can run them. OddsRule (odds_rule.h) decides how many islands
// to make.
//
// Archives store the islands as the scans of one chain. Each draw is an island's drawn state,
// weighted by the island's estimate of Z. An island whose particles all died adds a prior draw of
// weight 0. Invariant: the number of islands is a function of the islands' estimates, in order of
// island number. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/island_report.h"
#include "worker/sampling/numbered_lanes.h"
#include "worker/sampling/odds_rule.h"

namespace sleight::sampling {

struct FreeIslandsOptions {
  std::uint64_t seed = 0;
  double log_error = 0.1;  ///< Requested standard error of log P(satisfied), in nats.
  /// Maximum number of islands.
  std::optional<std::uint64_t> islands_max{};
};

class FreeIslands final : public plan::Plan {
 public:
  explicit FreeIslands(const FreeIslandsOptions& options);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return rule_.is_over() || scans_common() >= islands_max_; }
  /// Number of islands before the first unfinished island.
  std::uint64_t scans_common() const override { return islands_.scans(); }
  /// Always 0, because weighted draws aren't solutions in the model's proportions.
  std::uint64_t solutions_found() const override { return 0; }
  std::optional<std::uint64_t> solutions_wanted() const override { return std::nullopt; }
  std::vector<plan::Solution> solutions_between(std::uint64_t, std::uint64_t) const override {
    return {};
  }
  plan::Odds odds() const override;
  std::uint64_t scans_consumed() const override { return lanes_.consumed(); }
  std::optional<std::uint64_t> scans_total() const override;
  plan::Report report() const override;

 private:
  std::uint64_t end() const { return std::min(rule_.needed(), islands_max_); }

  NumberedLanes lanes_;
  std::uint64_t islands_max_;
  OddsRule rule_;
  std::map<std::uint64_t, IslandEstimate> ahead_;  ///< By number, before their turn.
  IslandsOfChain islands_;
};

}  // namespace sleight::sampling
