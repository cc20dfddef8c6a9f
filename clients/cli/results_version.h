// The results version. If two programs have the same results version, each can resume the other's
// runs, and both can compute one run together.
#pragma once

#include <string_view>

namespace sleight::programs {

/// Returns a hash of the sources and flags that determine a run's stored results, 16 hex digits
/// (deploy/version --results). Changes to clients, readers and documents don't change this hash.
std::string_view results_version();

}  // namespace sleight::programs
