// Failures of simulations as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "common/plan/failure.h"

namespace sleight::cli {

/// {"total": 3, "search_gave_up": 2, "work_limit": 1}: kinds that occurred alone.
nlohmann::ordered_json failures_json(const plan::FailureCounts& failures);

}  // namespace sleight::cli
