// Simulated tempering (Geyer and Thompson 1995, Annealing Markov chain Monte Carlo with
// applications to ancestral inference): one state whose temperature is itself a coordinate of the
// chain.
//
// The chain samples (level i, x) with density proportional to w_i p_w(x) p_c(x)^beta_i. With
// w_i = 1 / Z_i all levels are visited equally often; a burn-in has estimated log Z_i, and weights
// stay as they are from then on, so that the chain keeps its distribution whatever they are; that
// of the coolest level is 1. After each scan a level up or down is proposed, each with probability
// 1/2, and accepted with probability
//
//   min(1, exp((beta_j - beta_i) l + log w_j - log w_i)),    l = log p_c(x);
//
// a proposal beyond an end stays. States at inverse temperature 1 are draws from the target; at 0
// the scan is a draw from the prior, and a lineage begins.
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
  std::uint64_t scan_ = 0;  ///< the next
  std::uint32_t level_ = 0;
  std::uint64_t lineage_ = 0;
  bool handed_out_ = false;
  std::vector<std::uint64_t> visits_;    ///< scans, by level
  std::vector<std::uint64_t> proposed_;  ///< moves from a level to the next cooler one, or back
  std::vector<std::uint64_t> accepted_;
  std::vector<double> draw_scans_;
  bool was_hot_ = false;  ///< since it was coolest last
  std::uint64_t round_trips_ = 0;
  Solutions solutions_;
};

}  // namespace sleight::sampling
