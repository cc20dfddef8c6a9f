// A chain in which each scan ends with a tempered transition (tempered_transition.h). Steps between
// the burn-in's temperatures are added, because large steps are rarely accepted. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/sampling/chain_part.h"

namespace sleight::sampling {

class Excursions final : public ChainPart {
 public:
  /// REQUIRES: steps_per_level >= 1.
  Excursions(const BurnIn& burn_in, std::uint32_t steps_per_level);

  std::optional<plan::Unit> next_unit(std::uint64_t horizon, std::uint32_t scans_max) override;
  void consume(base::ReplicaId replica, std::uint64_t first_scan,
               std::span<const plan::ScanRecord> records) override;
  std::uint64_t scans() const override { return scan_; }
  std::uint64_t draws() const override { return scan_ - burn_in_.scans; }
  const Solutions& solutions() const override { return solutions_; }
  /// Each accepted excursion begins a lineage, because the ladder ends at the prior.
  std::vector<Row> rows() const override;

 private:
  BurnIn burn_in_;
  std::vector<double> below_;
  std::uint64_t scan_ = 0;  ///< The next scan.
  std::uint64_t lineage_ = 0;
  std::uint64_t accepted_ = 0;
  bool handed_out_ = false;
  Solutions solutions_;
};

}  // namespace sleight::sampling
