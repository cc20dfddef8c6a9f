// A Plan of chains that never interact. Each chain runs scans at inverse temperature 1 from its own
// prior draw. The kernel is plain Metropolis-Hastings, the baseline for all other methods.
// Alternatively, islands of particles start the chain and end each scan (worker/run/island_scan.h).
// Invariant: the scan at which the run stops is a function of the results up to that scan.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/furthest_behind.h"
#include "worker/sampling/island_report.h"
#include "worker/sampling/solutions.h"
#include "worker/sampling/stop_rule.h"

namespace sleight::sampling {

struct IndependentChainsOptions {
  std::uint64_t seed = 0;
  std::uint32_t chains = 1;
  std::uint64_t round_scans = 64;  ///< Length of the first round.
  /// Number of initial scans, which anneal the chain in equal steps. They belong to no round.
  std::uint64_t anneal_scans = 0;
  /// Number of burn-in scans after the annealing. Burn-in scans yield no draws or solutions and
  /// belong to no round.
  std::uint64_t burn_in_scans = 0;
  bool has_islands = false;  ///< Each scan ends with islands.
  StopRule stop;
};

class IndependentChains final : public plan::Plan {
 public:
  /// REQUIRES: chains >= 1, round_scans >= 1, at least one stop rule.
  explicit IndependentChains(const IndependentChainsOptions& options);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return behind_.least() >= stop_.end(); }
  std::uint64_t scans_common() const override { return std::min(behind_.least(), stop_.end()); }
  plan::Draws draws() const override;
  std::uint64_t solutions_found() const override;
  std::optional<std::uint64_t> solutions_wanted() const override {
    return stop_.solutions_wanted();
  }
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override;
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override {
    return stop_.rounds_between(after, until);
  }
  std::uint64_t scans_consumed() const override { return behind_.sum(stop_.end()); }
  std::optional<std::uint64_t> scans_total() const override;
  /// Reports the islands, if there are any. If solutions end the run, only islands up to the end of
  /// the first round count towards the odds, because these islands are made in any case.
  plan::Report report() const override;
  bool learns() const override { return has_islands_ || scans_before_draws_ > 0; }

 private:
  struct Chain {
    std::uint64_t consumed = 0;
    bool is_out = false;        ///< Whether a unit is handed out.
    std::uint64_t lineage = 0;  ///< The lineage of the last consumed state.
    Solutions solutions;
    IslandsOfChain islands;
  };

  bool counts(const plan::ScanRecord& record, std::uint64_t scan) const;

  std::uint64_t seed_;
  std::uint64_t anneal_scans_;
  std::uint64_t scans_before_draws_;
  bool has_islands_;
  std::vector<Chain> chains_;
  FurthestBehind behind_;
  StopJudge stop_;
};

}  // namespace sleight::sampling
