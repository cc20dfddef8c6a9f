// A Plan for methods that start from the results of a burn-in. Every chain runs some rounds of
// parallel tempering, and then its ChainPart (chain_part.h). The stop rule counts rounds from the
// burn-in's end. Scan counts include the burn-in.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/plan/plan.h"
#include "worker/sampling/chain_part.h"
#include "worker/sampling/furthest_behind.h"
#include "worker/sampling/ladder_run.h"
#include "worker/sampling/stop_rule.h"

namespace sleight::sampling {

struct BurntInOptions {
  std::uint32_t chains = 1;
  LadderOptions ladder;  ///< Options for each chain's burn-in. Its `chain` field is overwritten.
  std::uint32_t burn_in_rounds = 1;
  StopRule stop;
  std::function<std::unique_ptr<ChainPart>(const BurnIn&)> go_on;
};

class BurntInChains final : public plan::Plan {
 public:
  /// REQUIRES: at least one chain, one burn-in round and one stop rule.
  explicit BurntInChains(const BurntInOptions& options);

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
  /// First come the burn-in's rounds, ladder by ladder, then the stop rule's rounds. They are
  /// numbered consecutively.
  std::vector<plan::EndedRound> rounds_between(std::uint64_t after,
                                               std::uint64_t until) const override;
  /// Round trips of the burn-in.
  std::optional<std::uint64_t> round_trips() const override;
  std::uint64_t scans_consumed() const override { return records_; }
  std::optional<std::uint64_t> scans_total() const override { return std::nullopt; }
  /// Reports the burn-in's ladders and all parts' rows.
  plan::Report report() const override;

 private:
  struct Chain {
    LadderRun burn_in;
    std::unique_ptr<ChainPart> part;  ///< Null before the burn-in's end.
    /// Before the burn-in ends, a run store may already deliver later scans. They wait here.
    std::map<std::uint32_t, std::pair<std::uint64_t, std::vector<plan::ScanRecord>>> waiting;
    std::uint64_t scans() const { return part ? part->scans() : burn_in.scans(); }
  };
  void begin_part(Chain& chain);

  BurntInOptions options_;
  std::uint64_t burn_in_scans_;
  FurthestBehind order_;  ///< Order of the chains.
  StopJudge stop_;
  std::vector<Chain> chains_;
  std::size_t burning_ = 0;  ///< Number of chains in their burn-in.
  std::uint64_t records_ = 0;
};

}  // namespace sleight::sampling
