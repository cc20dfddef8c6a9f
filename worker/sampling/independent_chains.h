// Chains that never meet, as a Plan: each starts from its own prior draw and makes scan after scan
// at inverse temperature 1. Plain Metropolis-Hastings, the baseline of every other method; or
// chains whose scans end with islands of particles, which also start them
// (worker/run/island_scan.h).
//
// Rounds double: round r (from 1) has round_scans * 2^(r-1) scans of every chain. The number of
// independent solutions is judged at round ends only, so there all chains wait for the last one;
// the other stop rules need no barrier.
//
// Invariant: the scan at which the run stops is a function of the results up to that scan.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/island_report.h"
#include "worker/sampling/solutions.h"
#include "worker/sampling/stop_rule.h"

namespace sleight::sampling {

struct IndependentChainsOptions {
  std::uint64_t seed = 0;
  std::uint32_t chains = 1;
  std::uint64_t round_scans = 64;  ///< length of the first round
  /// Simulated annealing first: so many scans from the prior to inverse temperature 1, in equal
  /// steps. They belong to no round.
  std::uint64_t anneal_scans = 0;
  /// Scans after these that are no draws, nor are lineages that began in them counted. They belong
  /// to no round either.
  std::uint64_t burn_in_scans = 0;
  bool has_islands = false;  ///< at the end of each scan
  StopRule stop;
};

class IndependentChains final : public plan::Plan {
 public:
  /// REQUIRES: chains and round_scans at least 1, one stop rule at least.
  explicit IndependentChains(const IndependentChainsOptions& options);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override;
  std::uint64_t scans_common() const override;
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
  std::uint64_t scans_consumed() const override;
  std::optional<std::uint64_t> scans_total() const override;
  /// Of islands, where scans have some. Where solutions end the run, those of the first round and
  /// before it tell the odds: they are made in any case.
  plan::Report report() const override;
  bool learns() const override { return has_islands_ || scans_before_draws_ > 0; }

 private:
  struct Chain {
    std::uint64_t consumed = 0;
    std::uint64_t lineage = 0;  ///< of the state after these
    Solutions solutions;
    IslandsOfChain islands;
  };

  bool counts(const plan::ScanRecord& record, std::uint64_t scan) const;

  std::uint64_t common_consumed() const;
  /// Moves on over every round end that all chains have reached, and judges there.
  void judge_rounds();

  std::uint64_t seed_;
  std::uint64_t anneal_scans_;
  std::uint64_t scans_before_draws_;
  bool has_islands_;
  std::vector<Chain> chains_;
  using Progress = std::pair<std::uint64_t, std::uint32_t>;  ///< (consumed, chain)
  std::set<Progress> by_progress_;                           ///< all chains
  std::set<Progress> idle_;                                  ///< those with no unit handed out
  StopJudge stop_;
};

}  // namespace sleight::sampling
