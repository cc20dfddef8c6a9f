// Formats failures of simulations as JSON.
#pragma once

#include "common/json/value.h"
#include "common/plan/failure.h"

namespace sleight::analysis {

/// Returns, for example, {"total": 3, "search_gave_up": 2, "work_limit": 1}. Leaves out kinds that
/// didn't occur.
json::Value failures_json(const plan::FailureCounts& failures);

}  // namespace sleight::analysis
