// A free island's estimates (island.h), without the island's states. Each estimate occupies four
// `method_values` of a scan's record. The record has one estimate per free island of the scan.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "worker/sampling/log_sum.h"

namespace sleight::sampling {

struct IslandEstimate {
  static constexpr std::size_t k_values = 4;

  double log_z = k_log_zero;          ///< Log of an unbiased estimate of Z.
  double log_satisfied = k_log_zero;  ///< Log of an unbiased estimate of P(satisfied).
  double effective_size = 0;          ///< Effective size of the particles.
  bool accepted = false;              ///< Whether the island's draw became the chain's state.

  void append_to(std::vector<double>& values) const {
    values.insert(values.end(), {log_z, log_satisfied, effective_size, accepted ? 1.0 : 0.0});
  }
  /// Reads an estimate. REQUIRES: at least k_values values.
  static IslandEstimate of(std::span<const double> values) {
    return {.log_z = values[0],
            .log_satisfied = values[1],
            .effective_size = values[2],
            .accepted = values[3] != 0};
  }
};

}  // namespace sleight::sampling
