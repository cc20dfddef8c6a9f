// Parallel tempering as a Plan: several independent ladders (ladder_run.h), each a chain of the
// archive, whose draws are the states at inverse temperature 1.
//
// Replicas may start from searches, so that ladders know from their first round on what solutions
// are like. Then they burn in: until the end of the first round whose last scan has no state, at
// any level of any ladder, that descends from a search. Each replica has then been at the hottest
// level, where it was drawn from the prior anew. Earlier scans are no draws, and neither their
// solutions nor their rounds are told. A ladder whose swaps don't bring all replicas there never
// burns in.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/furthest_behind.h"
#include "worker/sampling/ladder_run.h"
#include "worker/sampling/stop_rule.h"

namespace sleight::sampling {

struct ParallelTemperingOptions {
  std::uint32_t ladders = 1;
  LadderOptions ladder;  ///< of each; its chain is set
  StopRule stop;
};

class ParallelTempering final : public plan::Plan {
 public:
  /// REQUIRES: a ladder and a stop rule at least.
  explicit ParallelTempering(const ParallelTemperingOptions& options);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  std::optional<plan::Block> next_block(const plan::BlockLimits& limits) override;
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
  /// Of each ladder, the burn-in's rounds too.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override;
  std::optional<std::uint64_t> round_trips() const override;
  /// Of all replicas.
  std::uint64_t scans_consumed() const override;
  /// With as many levels as there are now.
  std::optional<std::uint64_t> scans_total() const override;
  /// Over (chain, round): first scan, barrier, round trips and their rates, log Z, log
  /// P(satisfied); over (chain, round, level) what is known of levels.
  plan::Report report() const override;

  const std::vector<LadderRun>& ladders() const { return ladders_; }

 private:
  std::uint64_t anneal_scans_;
  /// What follows from all ladders' having come so far.
  void judge_burn_in();
  std::uint64_t solutions_before(std::uint64_t scan) const;
  /// Of a ladder, those that count. REQUIRES: the burn-in is over.
  const Solutions& solutions_of(const LadderRun& ladder) const;

  std::uint64_t round_scans_;
  bool starts_by_search_;
  /// The end of the burn-in, in scans, once it is known; without a search there is none.
  std::optional<std::uint64_t> burnt_in_at_;
  std::uint32_t rounds_judged_ = 0;
  std::vector<LadderRun> ladders_;
  FurthestBehind order_;  ///< of ladders
  StopJudge stop_;
};

}  // namespace sleight::sampling
