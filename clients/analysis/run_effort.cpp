#include "clients/analysis/run_effort.h"

#include <cmath>
#include <limits>
#include <vector>

#include "clients/analysis/after_burn_in.h"
#include "clients/analysis/request_numbers.h"
#include "clients/analysis/sampling_method.h"

namespace sleight::analysis {
namespace {

/// Returns a ladder's number of simulations. `starts`: scans in which each level simulates one new
/// draw.
double on_ladder(double levels, double scans, double starts, double each) {
  return starts * levels + (scans - starts) * (1 + each * (levels - 1));
}

double by_ladders(const archive::Source& source, const RunSizes& sizes, double each) {
  double sum = 0;
  for (std::size_t r = 0; r < sizes.rounds.size(); ++r) {
    const auto first = static_cast<double>(sizes.rounds[r].first_scan);
    const auto scans = static_cast<double>(sizes.rounds[r].scans);
    for (const double levels : of_ladders(source, "levels", sizes.chains, r)) {
      // Annealing scans precede the first round and include the starts.
      if (r == 0 && first > 0) sum += on_ladder(levels, first, 1, each);
      sum += on_ladder(levels, scans, first == 0 ? 1 : 0, each);
    }
  }
  return sum;
}

/// Simulations after a burn-in.
double by_chains(const archive::Source& source, const RunSizes& sizes, double each) {
  const auto draws = static_cast<double>(sizes.draws);
  double sum = 0;
  if (sizes.method == request::Method::simulated_tempering) {
    for (std::uint64_t c = 0; c < sizes.chains; ++c) {
      const std::vector<double> visits = row_of_chain(source, "walk_visits", "walk_level", c);
      for (std::size_t level = 0; level < visits.size(); ++level)
        sum += std::isnan(visits[level]) ? 0 : visits[level] * (level == 0 ? 1 : each);
    }
  } else if (sizes.method == request::Method::tempered_transitions) {
    // Each excursion goes to the prior and back, and makes one prior draw.
    for (const TransitionReport& chain : transitions_of(source, sizes.chains))
      sum += draws * (each + 2 * each * (chain.levels - 1) + 1);
  } else if (sizes.method == request::Method::annealed_importance) {
    for (const AscentReport& chain : ascents_of(source, sizes.chains))
      sum += draws * (1 + each * (chain.steps - 1));
  }
  return sum;
}

}  // namespace

double simulations_of(const archive::Source& source, const std::string& request_text,
                      const RunSizes& sizes) {
  const RequestNumbers numbers(request_text, source.name());
  const auto each = numbers.find("sampler", "iterations_per_scan");
  if (!each || draws_are_burnt_in(source, sizes.method))
    return std::numeric_limits<double>::quiet_NaN();
  if (sizes.rounds.empty()) {
    const double annealed = numbers.find("sampler", "anneal_scans").value_or(0);
    const double scans = annealed + static_cast<double>(sizes.draws);
    return static_cast<double>(sizes.chains) * (1 + *each * (scans - 1));
  }
  return by_ladders(source, sizes, *each) + by_chains(source, sizes, *each);
}

}  // namespace sleight::analysis
