// Annealed importance sampling (Neal 2001, Annealed importance sampling): independent ascents from
// the prior to inverse temperature 1. The weight of an ascent corrects for the ascent's finite
// speed.
//
// An ascent makes one scan at each inverse temperature 0 = beta_0 < beta_1 < ... < beta_K = 1. x_0
// is a draw from the prior, and the kernel of beta_k makes x_k. The log of the ascent's weight w is
//
//   log w = sum over k of (beta_k - beta_{k-1}) l(x_{k-1}),    l = log p_c.
//
// The mean of w is an unbiased estimate of Z. Weighted means over the ascents' last states estimate
// means under the target. Each lane runs one ascent after another. The levels come from a burn-in;
// an ascent makes `steps_per_level` equal steps between neighbouring levels. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/sampling/chain_part.h"
#include "worker/sampling/log_sum.h"
#include "worker/sampling/round_statistics.h"

namespace sleight::sampling {

/// Log of the mean weight, its standard error (delta method), and the effective size (sum w)^2 /
/// sum w^2.
struct WeightSummary {
  Estimate log_mean;
  double effective_size = 0;
};
/// Returns NaN without weights. The error is NaN for a single weight.
WeightSummary summary_of(std::span<const double> log_weights);

class AnnealedImportance final : public ChainPart {
 public:
  /// REQUIRES: at least one lane and one step per level.
  AnnealedImportance(const BurnIn& burn_in, std::uint32_t lanes, std::uint32_t steps_per_level);

  std::optional<plan::Unit> next_unit(std::uint64_t horizon, std::uint32_t scans_max) override;
  void consume(base::ReplicaId replica, std::uint64_t first_scan,
               std::span<const plan::ScanRecord> records) override;
  std::uint64_t scans() const override;
  /// Number of draws. A lane's n-th ascent yields a draw, which counts once all lanes have
  /// completed n ascents.
  std::uint64_t draws() const override;
  const Solutions& solutions() const override { return solutions_; }
  std::vector<Row> rows() const override;
  const char* warning() const override {
    return "draws are weighted; their log weights are in /tempering/log_weight";
  }

  const std::vector<double>& schedule() const { return betas_; }

 private:
  struct Lane {
    std::uint64_t scan = 0;  ///< The lane's next scan, counted from the part's first scan.
    bool handed_out = false;
    std::uint64_t lineage = 0;
    double log_weight = 0;
    double last_log_constraint = 0;
    /// Log weights of completed ascents.
    std::vector<double> log_weights;
    std::vector<double> log_satisfied;  ///< Logs of weight times 1{satisfied} / p_c.
  };
  std::uint64_t per_ascent() const { return betas_.size(); }
  base::ReplicaId lane_id(std::uint32_t lane) const {
    return base::ReplicaId{burn_in_.first_free.value + lane};
  }

  BurnIn burn_in_;
  std::vector<double> betas_;
  std::vector<std::vector<double>> scales_;  ///< Proposal scales by step.
  std::vector<Lane> lanes_;
  Solutions solutions_;
};

}  // namespace sleight::sampling
