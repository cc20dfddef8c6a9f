#include "worker/sampling/diagnostics/standard_error.h"

#include <cmath>

#include "worker/sampling/diagnostics/effective_sample_size.h"
#include "worker/sampling/diagnostics/transforms.h"

namespace sleight::sampling {

double mcse_mean(const Chains& draws) {
  return std::sqrt(variance_of(draws.values)) / std::sqrt(ess_mean(draws));
}

}  // namespace sleight::sampling
