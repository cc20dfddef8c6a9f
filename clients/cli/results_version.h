// The results version. Programs with the same results version can resume each other's runs and
// compute on one run together.
#pragma once

#include <string_view>

namespace sleight::programs {

/// Returns a hash of the sources and flags that determine a run's stored results, 16 hex digits
/// (deploy/version --results). Sources of clients, readers and documents don't affect it.
std::string_view results_version();

}  // namespace sleight::programs
