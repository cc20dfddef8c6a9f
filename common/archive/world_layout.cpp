#include "common/archive/world_layout.h"

#include <algorithm>
#include <cmath>

namespace sleight::archive {
namespace {

bool is_in_prior(const Variable& variable) {
  const bool is_all_normal =
      !variable.prior_sd.empty() &&
      std::ranges::none_of(variable.prior_sd, [](double sd) { return std::isnan(sd); });
  return !is_all_normal || variable.size() <= k_prior_elements_max;
}

}  // namespace

std::vector<Variable> prior_variables(const WorldLayout& layout) {
  std::vector<Variable> kept;
  for (const Variable& variable : layout.variables) {
    if (is_in_prior(variable)) kept.push_back(variable);
  }
  return kept;
}

std::vector<double> prior_values(const WorldLayout& layout, std::span<const double> values) {
  std::vector<double> kept;
  for (const Variable& variable : layout.variables) {
    const std::span<const double> own = values.first(variable.size());
    if (is_in_prior(variable)) kept.insert(kept.end(), own.begin(), own.end());
    values = values.subspan(variable.size());
  }
  return kept;
}

}  // namespace sleight::archive
