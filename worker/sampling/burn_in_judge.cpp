#include "worker/sampling/burn_in_judge.h"

#include <algorithm>

#include "worker/sampling/diagnostics/r_hat.h"

namespace sleight::sampling {

ValueVerdict judge_value(const BurnInValue& value, std::span<const double> starts,
                         const Chains& draws) {
  ValueVerdict verdict{.r_hat = r_hat(draws)};
  const bool has_left = std::ranges::any_of(
      draws.values, [&](double draw) { return std::ranges::find(starts, draw) == starts.end(); });
  if (value.starts_at_one_end && !has_left) return verdict;
  // If a value is constant in all chains, it passes unless it has to change.
  const bool is_constant =
      std::ranges::all_of(draws.values, [&](double draw) { return draw == draws.values.front(); });
  verdict.passes = is_constant || verdict.r_hat <= k_burnt_in_r_hat;
  return verdict;
}

}  // namespace sleight::sampling
