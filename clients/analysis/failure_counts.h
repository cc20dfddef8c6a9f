// Failures of simulations as JSON.
#pragma once

#include "common/json/value.h"
#include "common/plan/failure.h"

namespace sleight::analysis {

/// {"total": 3, "search_gave_up": 2, "work_limit": 1}: kinds that occurred alone.
json::Value failures_json(const plan::FailureCounts& failures);

}  // namespace sleight::analysis
