// What a free island (island.h) says of its target, for those who hold no states: four of the
// method_values of a scan's record, which has those of each free island of the scan.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "worker/sampling/log_sum.h"

namespace sleight::sampling {

struct IslandEstimate {
  static constexpr std::size_t k_values = 4;

  double log_z = k_log_zero;          ///< of an unbiased estimate of Z; -infinity: all died
  double log_satisfied = k_log_zero;  ///< likewise of P(satisfied)
  double effective_size = 0;          ///< of its particles, by weight
  bool accepted = false;              ///< its draw became the chain's state

  void append_to(std::vector<double>& values) const {
    values.insert(values.end(), {log_z, log_satisfied, effective_size, accepted ? 1.0 : 0.0});
  }
  /// REQUIRES: k_values values of an estimate.
  static IslandEstimate of(std::span<const double> values) {
    return {.log_z = values[0],
            .log_satisfied = values[1],
            .effective_size = values[2],
            .accepted = values[3] != 0};
  }
};

}  // namespace sleight::sampling
