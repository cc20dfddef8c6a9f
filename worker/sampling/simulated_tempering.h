// Simulated tempering (Geyer and Thompson 1995, Annealing Markov chain Monte Carlo with
// applications to ancestral inference): the temperature is itself a coordinate.
//
// The chain samples (level i, x) with density proportional to w_i p_w(x) p_c(x)^beta_i. With w_i =
// 1 / Z_i the chain visits all levels equally often. The weights come from a burn-in. The coolest
// level has weight 1. All weights are then fixed, so the chain keeps its distribution even if the
// weights are inaccurate. After each scan the chain proposes one level up or down, each with
// probability 1/2, and accepts with probability
//
//   min(1, exp((beta_j - beta_i) l + log w_j - log w_i)),    l = log p_c(x).
//
// A proposal beyond an end leaves the level unchanged. States at inverse temperature 1 are draws
// from the target. At inverse temperature 0 the scan is a draw from the prior and begins a lineage.
// Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/sampling/chain_part.h"

namespace sleight::sampling {

class SimulatedTempering final : public ChainPart {
 public:
  explicit SimulatedTempering(const BurnIn& burn_in);

  std::optional<plan::Unit> next_unit(std::uint64_t horizon, std::uint32_t scans_max) override;
  void consume(base::ReplicaId replica, std::uint64_t first_scan,
               std::span<const plan::ScanRecord> records) override;
  std::uint64_t scans() const override { return scan_; }
  std::uint64_t draws() const override { return visits_.back(); }
  const Solutions& solutions() const override { return solutions_; }
  std::vector<Row> rows() const override;

 private:
  void move(double log_constraint);

  BurnIn burn_in_;
  std::vector<double> log_weights_;
  std::uint64_t scan_ = 0;  ///< The next scan.
  std::uint32_t level_ = 0;
  std::uint64_t lineage_ = 0;
  bool handed_out_ = false;
  std::vector<std::uint64_t> visits_;    ///< Number of scans by level.
  std::vector<std::uint64_t> proposed_;  ///< By gap: moves in both directions.
  std::vector<std::uint64_t> accepted_;
  std::vector<double> draw_scans_;
  bool was_hot_ = false;  ///< Whether the chain has been hottest since it was last coolest.
  std::uint64_t round_trips_ = 0;
  Solutions solutions_;
};

}  // namespace sleight::sampling
