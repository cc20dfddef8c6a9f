#include "clients/analysis/after_burn_in.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clients/analysis/tempering.h"

namespace sleight::analysis {
namespace {

/// Removes NaN entries at the end. A row has such entries if other chains have longer rows.
std::vector<double> known(std::vector<double> values) {
  while (!values.empty() && std::isnan(values.back()))
    values.pop_back();
  return values;
}

}  // namespace

std::vector<WalkReport> walks_of(const archive::Source& source, std::uint64_t chains) {
  std::vector<WalkReport> walks;
  for (const double trips : of_chains(source, "walk_round_trips", chains)) {
    const std::uint64_t chain = walks.size();
    const auto row = [&](std::string_view name) {
      return row_of_chain(source, name, "walk_level", chain);
    };
    WalkReport walk{.round_trips = trips,
                    .inverse_temperature = known(row("walk_inverse_temperature")),
                    .visits = row("walk_visits"),
                    .acceptance = row("walk_acceptance")};
    const std::size_t levels = walk.inverse_temperature.size();
    walk.visits.resize(levels, std::numeric_limits<double>::quiet_NaN());
    walk.acceptance.resize(levels, std::numeric_limits<double>::quiet_NaN());
    walks.push_back(std::move(walk));
  }
  return walks;
}

std::vector<TransitionReport> transitions_of(const archive::Source& source, std::uint64_t chains) {
  std::vector<TransitionReport> transitions;
  for (const double acceptance : of_chains(source, "excursion_acceptance", chains)) {
    const std::vector<double> levels = known(row_of_chain(source, "excursion_inverse_temperature",
                                                          "excursion_level", transitions.size()));
    transitions.push_back({.acceptance = acceptance, .levels = static_cast<double>(levels.size())});
  }
  return transitions;
}

std::vector<AscentReport> ascents_of(const archive::Source& source, std::uint64_t chains) {
  const auto numbers = [&](std::string_view name) { return of_chains(source, name, chains); };
  const std::vector<double> sizes = numbers("ais_effective_size");
  const std::vector<double> log_z = numbers("ais_log_z");
  const std::vector<double> log_z_error = numbers("ais_log_z_error");
  const std::vector<double> log_p = numbers("ais_log_p_satisfied");
  const std::vector<double> log_p_error = numbers("ais_log_p_satisfied_error");
  std::vector<AscentReport> ascents;
  for (std::uint64_t c = 0; c < chains; ++c) {
    const std::vector<double> steps =
        known(row_of_chain(source, "ascent_inverse_temperature", "ascent_step", c));
    ascents.push_back({.effective_size = sizes[c],
                       .steps = static_cast<double>(steps.size()),
                       .log_z = {log_z[c], log_z_error[c]},
                       .log_p_satisfied = {log_p[c], log_p_error[c]}});
  }
  return ascents;
}

double effective_size_of_all(const archive::Source& source) {
  // Find the greatest weight first, so that no sum overflows.
  double greatest = -std::numeric_limits<double>::infinity();
  bool unknown = true;
  for_each_of_draws(source, "log_weight", [&](double log_weight) {
    unknown = false;
    greatest = std::isnan(log_weight) ? log_weight : std::max(greatest, log_weight);
  });
  if (unknown || std::isnan(greatest)) return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(greatest) && greatest < 0) return 0;
  double sum = 0;
  double squares = 0;
  for_each_of_draws(source, "log_weight", [&](double log_weight) {
    const double weight = std::exp(log_weight - greatest);
    sum += weight;
    squares += weight * weight;
  });
  return sum * sum / squares;
}

}  // namespace sleight::analysis
