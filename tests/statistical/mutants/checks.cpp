#include "tests/statistical/mutants/checks.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "common/base/check.h"
#include "tests/statistical/support/rank_tests.h"

namespace sleight::statistical {

const std::vector<Check>& checks() {
  static const std::vector<Check> all{
      {CheckId::kernel_keeps, "kernel keeps", kernel_keeps, 2, false, true},
      {CheckId::kernel_moves, "kernel moves", kernel_moves, 1, false, true},
      {CheckId::scans_move, "scans move", scans_move, 1, false, true},
      {CheckId::draws_are_fresh, "draws are fresh", draws_are_fresh, 3, false, true},
      {CheckId::ladder_keeps, "ladder keeps", ladder_keeps, 6, false, false},
      {CheckId::replicas_travel, "replicas travel", replicas_travel, 2, false, true},
      {CheckId::stones_weigh, "stones weigh", stones_weigh, 4, false, false},
      {CheckId::ascents_weigh, "ascents weigh", ascents_weigh, 2, false, true},
      {CheckId::levels_walk, "levels walk", levels_walk, 1, false, true},
      {CheckId::excursions_keep, "excursions keep", excursions_keep, 2, false, true},
      {CheckId::parts_are_found, "parts are found", parts_are_found, 2, false, false},
      {CheckId::modes_are_found, "modes are found", modes_are_found, 1, false, false},
      {CheckId::lineages_are_right, "lineages are right", lineages_are_right, 1, true, true},
      {CheckId::excursions_descend, "excursions descend", excursions_descend, 1, true, true},
      {CheckId::results_are_pure, "results are pure", results_are_pure, 1, true, true},
      {CheckId::rounds_are_frozen, "rounds are frozen", rounds_are_frozen, 1, true, true},
  };
  return all;
}

const Check& check_of(CheckId id) {
  const auto found = std::ranges::find(checks(), id, &Check::id);
  CHECK(found != checks().end());
  return *found;
}

double mean_p(std::span<const double> draws, double mean) {
  const auto n = static_cast<double>(draws.size());
  const MeanWithError seen = mean_of_independent(draws);
  if (!std::isfinite(seen.mean) || !std::isfinite(seen.standard_error)) return 0;
  if (seen.standard_error == 0) return seen.mean == mean ? 1 : 0;
  const double t = (seen.mean - mean) / seen.standard_error * std::sqrt((n - 1) / n);
  return 2 * boost::math::cdf(boost::math::students_t(n - 1), -std::abs(t));
}

}  // namespace sleight::statistical
