#include "worker/sampling/diagnostics/convergence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "worker/sampling/diagnostics/effective_sample_size.h"
#include "worker/sampling/diagnostics/r_hat.h"
#include "worker/sampling/diagnostics/transforms.h"

namespace sleight::sampling {
namespace {

bool all_equal(std::span<const double> values) {
  return std::ranges::all_of(values, [&](double value) { return value == values.front(); });
}

std::size_t count_not_finite(std::span<const double> values) {
  const auto is_not_finite = [](double value) { return !std::isfinite(value); };
  return static_cast<std::size_t>(std::ranges::count_if(values, is_not_finite));
}

/// Returns "3 of 4 chains never move and ", or nothing if all chains move.
std::string who_never_moves(const Convergence& convergence) {
  if (convergence.unmoved == 0) return "";
  return fmt::format("{} of {} chains never move{} and ", convergence.unmoved, convergence.chains,
                     convergence.unmoved == 1 ? "s" : "");
}

}  // namespace

Convergence convergence_of(const Chains& draws) {
  check_shape(draws);
  Convergence found{.chains = draws.chains,
                    .draws = draws.draws,
                    .not_finite = count_not_finite(draws.values),
                    .mean = mean_of(draws.values),
                    .sd = std::sqrt(variance_of(draws.values)),
                    .mcse_mean = mcse_mean(draws),
                    .r_hat_bulk = r_hat_bulk(draws),
                    .ess_bulk = ess_bulk(draws),
                    .ess_tail = ess_tail(draws)};
  found.r_hat = r_hat(draws);
  for (std::size_t c = 0; c < draws.chains; ++c)
    found.unmoved += all_equal(draws.chain(c)) ? 1 : 0;
  found.constant = found.not_finite == 0 && all_equal(draws.values);
  return found;
}

double ess_wanted(std::size_t chains) {
  return std::max(k_ess_min, k_ess_per_chain_min * static_cast<double>(chains));
}

std::vector<std::string> complaints(std::string_view name, const Convergence& convergence) {
  if (convergence.constant) return {};
  if (convergence.not_finite > 0) {
    return {fmt::format("{}: {} of {} draws are NaN or infinite, so convergence can't be judged",
                        name, convergence.not_finite, convergence.chains * convergence.draws)};
  }
  if (convergence.draws < k_draws_per_chain_min) {
    return {fmt::format(
        "{}: {} draws per chain are too few to judge convergence; at least {} are needed", name,
        convergence.draws, k_draws_per_chain_min)};
  }

  std::vector<std::string> reasons;
  const bool has_tail = !std::isnan(convergence.r_hat);
  const double ratio = has_tail ? convergence.r_hat : convergence.r_hat_bulk;
  if (convergence.chains > 1 && convergence.unmoved == convergence.chains) {
    reasons.push_back(
        fmt::format("{}: no chain ever moves, and the chains stay at different values", name));
  } else if (!(ratio <= k_r_hat_max)) {
    reasons.push_back(fmt::format("{}: {}R-hat is {:.3f}, above {}: the chains disagree, or drift",
                                  name, who_never_moves(convergence), ratio, k_r_hat_max));
  }
  const double wanted = ess_wanted(convergence.chains);
  if (!(convergence.ess_bulk >= wanted)) {
    reasons.push_back(fmt::format("{}: the bulk effective sample size is {:.0f}, below {:.0f}",
                                  name, std::floor(convergence.ess_bulk), wanted));
  }
  if (convergence.ess_tail < wanted) {
    reasons.push_back(fmt::format("{}: the tail effective sample size is {:.0f}, below {:.0f}",
                                  name, std::floor(convergence.ess_tail), wanted));
  }
  return reasons;
}

}  // namespace sleight::sampling
