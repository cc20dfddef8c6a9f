#include "worker/worlds/user_scene/check/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sleight::worlds::user_scene {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
/// With fewer draws, a constraint that none comes near isn't surprising.
constexpr std::uint64_t k_draws_min = 50;
/// A distance of more than this many sigmas is far.
constexpr double k_far = 3;

}  // namespace

PriorDraws prior_draws(const UserScene& world, std::uint64_t count_max,
                       const std::function<bool(std::uint64_t done)>& go_on) {
  const std::vector<Constraint>& constraints = world.parameters().constraints;
  PriorDraws draws{.constraint_met = std::vector<std::uint64_t>(constraints.size(), 0),
                   .least_distances = std::vector<double>(constraints.size(), k_infinity)};
  while (draws.count < count_max && (draws.count == 0 || go_on(draws.count))) {
    const State state = sampling::nth_prior_draw(world, draws.count++);
    const std::vector<double> values = world.quantities().values(state.numbers);
    draws.values.resize(values.size(), {k_infinity, 0, -k_infinity});
    for (std::size_t i = 0; i < values.size(); ++i) {
      auto& [least, mean, greatest] = draws.values[i];
      least = std::min(least, values[i]);
      mean += (values[i] - mean) / static_cast<double>(draws.count);
      greatest = std::max(greatest, values[i]);
    }
    const Outcome outcome = world.simulate(state);
    draws.overlap += outcome.end == End::impossible ? 1 : 0;
    draws.failed += outcome.end == End::failed ? 1 : 0;
    draws.not_settled += outcome.end == End::time_limit ? 1 : 0;
    draws.met += world.satisfied(outcome) ? 1 : 0;
    for (std::size_t i = 0; i < outcome.judgement.distances.size(); ++i) {
      const double distance = outcome.judgement.distances[i];
      draws.constraint_met[i] += outcome.judgement.met[i] ? 1 : 0;
      draws.least_distances[i] = std::min(draws.least_distances[i], distance);
    }
  }
  return draws;
}

std::vector<std::string> warnings_of(const UserScene& world, const PriorDraws& draws) {
  std::vector<std::string> all;
  const auto share = [&](std::uint64_t count, const char* what) {
    if (count > 0)
      all.push_back(fmt::format("In {} of {} prior draws, {}.", count, draws.count, what));
  };
  share(draws.overlap,
        "bodies overlap where one starts, one can't rest there, or a box is too flat; such draws "
        "have p_c = 0");
  share(draws.failed, "the simulator fails; such draws are never samples");
  share(draws.not_settled, "a body still moves at end_s, so it isn't at rest");
  for (std::size_t i = 0; draws.count >= k_draws_min && i < draws.least_distances.size(); ++i) {
    const Constraint& one = world.parameters().constraints[i];
    const double distance = draws.least_distances[i];
    if (!std::isfinite(distance) || distance <= std::max(one.tolerance, k_far * one.sigma))
      continue;
    all.push_back(fmt::format(
        "None of {} prior draws comes near constraint '{}': the least distance is {:.4g} {}.",
        draws.count, one.name, distance / unit_of(one).scale, unit_of(one).name));
  }
  return all;
}

}  // namespace sleight::worlds::user_scene
