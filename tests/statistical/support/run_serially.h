// The simplest executor of a plan. Runs one unit at a time, and stores states by replica.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/plan/plan.h"

namespace sleight::statistical {

using Observe = std::function<void(const plan::UnitResult&)>;

/// Runs the plan until it is finished. Calls `observe` with each result before the plan consumes
/// it. REQUIRES: the plan is fresh.
void run_serially(plan::Plan& plan, const plan::UnitWorker& worker, const Observe& observe);

/// Runs the plan, and computes `value` of each scan at inverse temperature 1 from `first_scan` on.
/// Returns each chain's values in scan order. REQUIRES: each chain has one such record per scan.
std::vector<std::vector<double>> run_and_collect(
    plan::Plan& plan, const plan::UnitWorker& worker, std::uint64_t first_scan,
    const std::function<double(const plan::ScanRecord&)>& value);

}  // namespace sleight::statistical
