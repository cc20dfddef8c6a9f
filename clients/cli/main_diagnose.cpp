#include "clients/cli/main_diagnose.h"

#include <string_view>

#include "worker/sampling/diagnostics/convergence.h"

namespace sleight::programs {
namespace {

cli::Verdict judge(std::string_view name, const cli::ScalarDraws& draws) {
  // Where thin is longer than the judged scans, no state is archived of them.
  if (draws.draws == 0) return {};
  const sampling::Convergence found = sampling::convergence_of(
      {.values = draws.values, .chains = draws.chains, .draws = draws.draws});
  return {.mean = found.mean,
          .sd = found.sd,
          .mcse = found.mcse_mean,
          .r_hat = found.r_hat,
          .ess_bulk = found.ess_bulk,
          .ess_tail = found.ess_tail,
          .constant = found.constant,
          .complaints = sampling::complaints(name, found)};
}

}  // namespace

cli::Rules convergence_rules() {
  return {.draws_min = sampling::k_draws_per_chain_min,
          .ess_wanted = sampling::ess_wanted,
          .judge = judge};
}

}  // namespace sleight::programs
