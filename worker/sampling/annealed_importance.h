// Annealed importance sampling (Neal 2001, Annealed importance sampling): independent ascents from
// the prior to inverse temperature 1, each with a weight that makes up for what it was too fast
// for.
//
// An ascent goes through 0 = beta_0 < beta_1 < ... < beta_K = 1, a scan at each: a draw from the
// prior x_0, then x_k by the kernel of beta_k. Its weight is
//
//   log w = sum over k of (beta_k - beta_{k-1}) l(x_{k-1}),    l = log p_c;
//
// the mean of w estimates Z without bias, and weighted means over the last states estimate those of
// the target. Ascents run in lanes beside each other; a lane goes from one ascent to the next.
// Temperatures are those that a burn-in found, with `steps_per_level` steps between each two.
// Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/sampling/chain_part.h"
#include "worker/sampling/log_sum.h"
#include "worker/sampling/round_statistics.h"

namespace sleight::sampling {

/// Of weighted draws (l in logs): log of the mean weight, its standard error by the delta method,
/// and how many draws of equal weights would say as much: (sum w)^2 / sum w^2.
struct WeightSummary {
  Estimate log_mean;
  double effective_size = 0;
};
/// NaN of no weights; without an error of one.
WeightSummary summary_of(std::span<const double> log_weights);

class AnnealedImportance final : public ChainPart {
 public:
  /// REQUIRES: a lane and a step at least.
  AnnealedImportance(const BurnIn& burn_in, std::uint32_t lanes, std::uint32_t steps_per_level);

  std::optional<plan::Unit> next_unit(std::uint64_t horizon, std::uint32_t scans_max) override;
  void consume(base::ReplicaId replica, std::uint64_t first_scan,
               std::span<const plan::ScanRecord> records) override;
  std::uint64_t scans() const override;
  /// In the order of (scan, lane).
  std::uint64_t draws() const override;
  const Solutions& solutions() const override { return solutions_; }
  std::vector<Row> rows() const override;
  const char* warning() const override {
    return "draws are weighted; their log weights are in /tempering/log_weight";
  }

  const std::vector<double>& schedule() const { return betas_; }

 private:
  struct Lane {
    std::uint64_t scan = 0;  ///< the next, from the part's first
    bool handed_out = false;
    std::uint64_t lineage = 0;
    double log_weight = 0;
    double last_log_constraint = 0;
    /// Of ascents that have ended.
    std::vector<double> log_weights;
    std::vector<double> log_satisfied;  ///< weight times 1{satisfied} / p_c
  };
  std::uint64_t per_ascent() const { return betas_.size(); }
  base::ReplicaId lane_id(std::uint32_t lane) const {
    return base::ReplicaId{burn_in_.first_free.value + lane};
  }

  BurnIn burn_in_;
  std::vector<double> betas_;
  std::vector<std::vector<double>> scales_;  ///< by step
  std::vector<Lane> lanes_;
  Solutions solutions_;
};

}  // namespace sleight::sampling
