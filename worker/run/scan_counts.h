// Counts of a scan or of a search's start: proposals, failed simulations, and overlapping starts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/plan/unit.h"
#include "worker/sampling/metropolis_hastings.h"
#include "worker/sampling/target.h"

namespace sleight::run {

struct ScanCounts {
  explicit ScanCounts(std::uint32_t kinds) : proposed(kinds, 0), accepted(kinds, 0) {}
  void add(const sampling::StepReport& step) {
    ++proposed[step.kind];
    if (step.accepted) ++accepted[step.kind];
    add(step.simulation);
  }
  void add(const sampling::SimulationReport& report) {
    if (report.starts_overlap) ++overlapping_starts;
    if (report.failure == nullptr) return;
    failures.add(report.failure->kind);
    if (failed.size() < plan::k_failed_told_max) failed.push_back(report.failure);
  }
  void add(std::span<const plan::FailurePointer> all) {
    for (const plan::FailurePointer& failure : all)
      add(sampling::SimulationReport{.failure = failure});
  }
  /// Appends the failed simulations to the unit's list, up to the limit.
  void tell_failed(std::uint64_t scan, std::vector<plan::FailedSimulation>& of_unit) const {
    for (const plan::FailurePointer& failure : failed) {
      if (of_unit.size() == plan::k_failed_told_max) return;
      of_unit.push_back({.scan = base::ScanIndex{scan}, .failure = *failure});
    }
  }

  std::vector<std::uint32_t> proposed;  ///< By kind.
  std::vector<std::uint32_t> accepted;
  std::uint64_t overlapping_starts = 0;
  plan::FailureCounts failures{};
  std::vector<plan::FailurePointer> failed{};  ///< The first ones.
};

}  // namespace sleight::run
