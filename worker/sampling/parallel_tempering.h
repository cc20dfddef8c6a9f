// Parallel tempering as a Plan: several independent ladders (ladder_run.h), each a chain of the
// archive, whose draws are the states at inverse temperature 1.
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
  std::vector<LadderRun> ladders_;
  FurthestBehind order_;  ///< of ladders
  StopJudge stop_;
};

}  // namespace sleight::sampling
