// Parallel tempering as a Plan. Ladders (ladder_run.h) are independent; each is a chain of the
// archive. The draws are the states at inverse temperature 1.
//
// If replicas start from searches, the first rounds already contain solutions. The ladders then
// burn in until each replica has been redrawn from the prior: in the last scan of a round, no state
// descends from a search. Earlier scans yield no draws, and their solutions and rounds are not
// reported. If a ladder's swaps don't bring all replicas to the hottest level, the ladder never
// burns in.
#pragma once

#include <algorithm>
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
  LadderOptions ladder;  ///< Options of each ladder. Their `chain` field is overwritten.
  StopRule stop;
};

class ParallelTempering final : public plan::Plan {
 public:
  /// REQUIRES: at least one ladder and one stop rule.
  explicit ParallelTempering(const ParallelTemperingOptions& options);

  std::optional<plan::Unit> next_unit(std::uint32_t scans_max) override;
  std::optional<plan::Block> next_block(const plan::BlockLimits& limits) override;
  void consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
               std::span<const plan::ScanRecord> records) override;
  bool finished() const override { return order_.least() >= stop_.end(); }
  std::uint64_t scans_common() const override { return std::min(order_.least(), stop_.end()); }
  plan::Draws draws() const override;
  std::uint64_t solutions_found() const override;
  std::optional<std::uint64_t> solutions_wanted() const override {
    return stop_.solutions_wanted();
  }
  std::vector<plan::Solution> solutions_between(std::uint64_t after,
                                                std::uint64_t until) const override;
  /// Each ladder's rounds, including the burn-in's rounds.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override;
  std::optional<std::uint64_t> round_trips() const override;
  std::uint64_t scans_consumed() const override;
  /// An estimate that assumes the current numbers of levels.
  std::optional<std::uint64_t> scans_total() const override;
  /// Tables of rounds (barrier, round trips, log Z, log P(satisfied)) and tables of the rounds'
  /// levels.
  plan::Report report() const override;

  const std::vector<LadderRun>& ladders() const { return ladders_; }

 private:
  std::uint64_t anneal_scans_;
  void judge_burn_in();
  std::uint64_t solutions_before(std::uint64_t scan) const;
  /// A ladder's solutions after the burn-in. REQUIRES: the burn-in is over.
  const Solutions& solutions_of(const LadderRun& ladder) const;

  std::uint64_t round_scans_;
  bool starts_by_search_;
  /// The end of the burn-in, in scans, once known. Without a search, the burn-in is empty.
  std::optional<std::uint64_t> burnt_in_at_;
  std::uint32_t rounds_judged_ = 0;
  std::vector<LadderRun> ladders_;
  FurthestBehind order_;  ///< Order of the ladders.
  StopJudge stop_;
};

}  // namespace sleight::sampling
