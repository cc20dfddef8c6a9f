#include "clients/analysis/odds_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sleight::analysis {
namespace {

struct Whose {
  const char* one;
  const char* many;
};
constexpr Whose k_ladders{"ladder", "ladders"};
constexpr Whose k_chains{"chain", "chains"};

std::string so_many(std::size_t count, const Whose& whose) {
  return fmt::format("{} {}", count, count == 1 ? whose.one : whose.many);
}

/// Uncertainty of a ladder's log estimate: its own error or the ladders' spread, whichever is
/// larger.
double spread_of(const CombinedEstimate& all) {
  const auto ladders = static_cast<double>(all.ladders);
  return std::sqrt(ladders) * std::fmax(all.own_error, all.between_error);
}

void doubt_values(std::vector<Doubt>& doubts, const CombinedEstimate& all, std::size_t ladders,
                  const Whose& whose, const std::string& where) {
  if (all.ladders == ladders) return;
  doubts.push_back({.kind = DoubtOf::no_value,
                    .reason = fmt::format("no solution in {} of {}{}", ladders - all.ladders,
                                          so_many(ladders, whose), where),
                    .at_least = true});
}

void doubt_round_trips(std::vector<Doubt>& doubts, const LadderFacts& facts) {
  const std::vector<double>& trips = facts.round_trips;
  // If the number of trips is unknown, it counts as 0.
  const auto below = [&](double wanted) {
    return std::ranges::count_if(trips, [&](double made) { return !(made >= wanted); });
  };
  double sum = 0;
  double least = k_trips_each;
  for (const double made : trips) {
    sum += std::fmax(made, 0);
    least = std::min(least, std::fmax(made, 0));
  }
  if (below(k_trips_each) == 0 && sum >= k_renewals_in_all) return;
  Doubt doubt{.kind = DoubtOf::few_round_trips,
              .longer = std::max(k_trips_each / std::max(least, 1.0),
                                 k_renewals_in_all / std::max(sum, 1.0)),
              .at_least = least < 1};
  const std::string all = so_many(trips.size(), k_ladders);
  if (below(1) > 0) {
    doubt.reason = fmt::format(
        "{} of {} made no round trip in {}; each ladder needs at least {:.0f} round trips",
        below(1), all, facts.round, k_trips_each);
  } else if (below(k_trips_each) > 0) {
    doubt.reason = fmt::format("{} of {} made fewer than {:.0f} round trips in {}",
                               below(k_trips_each), all, k_trips_each, facts.round);
  } else {
    doubt.reason =
        fmt::format("{} made {:.0f} round trips in {}; in total, at least {:.0f} are needed", all,
                    sum, facts.round, k_renewals_in_all);
  }
  doubts.push_back(std::move(doubt));
}

void doubt_drift(std::vector<Doubt>& doubts, const LadderFacts& facts,
                 const CombinedEstimate& judged) {
  if (facts.before.empty()) {
    doubts.push_back(
        {.kind = DoubtOf::first_round,
         .reason = fmt::format("{} has no earlier round to compare with, so it is "
                               "unknown whether the chains still depend on their starts",
                               facts.round)});
    return;
  }
  const CombinedEstimate before = combined(facts.before);
  const double change = judged.log.value - before.log.value;
  const double error = std::hypot(judged.log.error, before.log.error);
  if (before.ladders < facts.before.size() || !std::isfinite(error)) {
    doubts.push_back(
        {.kind = DoubtOf::rounds_disagree,
         .reason = fmt::format(
             "the round before {} can't be compared, because it is too short or has no solution",
             facts.round)});
  } else if (!(std::abs(change) <= k_drift_max * error)) {
    doubts.push_back({.kind = DoubtOf::rounds_disagree,
                      .reason = fmt::format(
                          "the estimates of {} and the previous round differ by {:.2f} +- {:.2f}, "
                          "so the estimate is still drifting",
                          facts.round, std::abs(change), error),
                      .at_least = true});
  }
}

void doubt_spread(std::vector<Doubt>& doubts, const CombinedEstimate& all, const Whose& whose) {
  const double spread = spread_of(all);
  if (!std::isfinite(all.own_error)) {
    doubts.push_back(
        {.kind = DoubtOf::wide,
         .reason = fmt::format(
             "not every {} has an error estimate, because too few draws are solutions", whose.one),
         .at_least = true});
  } else if (!(spread <= k_spread_max)) {
    // The variance is inversely proportional to the number of scans.
    doubts.push_back(
        {.kind = DoubtOf::wide,
         .reason = fmt::format(
             "the log estimate of a single {} has an error of {:.1f}; at most {:.0f} is allowed",
             whose.one, spread, k_spread_max),
         .longer = std::max(spread * spread / (k_spread_max * k_spread_max), 2.0),
         .at_least = true});
  }
  if (all.between_error > k_disagreement_max * all.own_error) {
    doubts.push_back(
        {.kind = DoubtOf::ladders_disagree,
         .reason = fmt::format(
             "the spread between {} is {:.1f} times the spread expected from their own errors",
             whose.many, all.between_error / all.own_error),
         .at_least = true});
  }
}

/// Returns why the number of islands isn't trusted. Empty: it is trusted.
const char* reason_not_sized(IslandNumber number) {
  switch (number) {
    case IslandNumber::fixed:
    case IslandNumber::sized:
      return "";
    case IslandNumber::unfinished:
      return "the batch of islands that determines the odds is not complete yet";
    case IslandNumber::by_solutions:
      return "the stop rule independent_solutions biases the odds until the first batch of islands "
             "is complete";
    case IslandNumber::unknown:
      return "the request does not show how the number of islands was chosen";
  }
  return "";
}

}  // namespace

std::vector<Doubt> doubts_of(const LadderFacts& facts) {
  std::vector<Doubt> doubts;
  const CombinedEstimate judged = combined(facts.judged);
  doubt_values(doubts, judged, facts.judged.size(), k_ladders, " in " + facts.round);
  doubt_round_trips(doubts, facts);
  if (judged.ladders == 0) return doubts;
  doubt_drift(doubts, facts, judged);
  doubt_spread(doubts, judged, k_ladders);
  return doubts;
}

std::vector<Doubt> doubts_of_weights(std::span<const LogEstimate> chains, double effective_size,
                                     double effective_size_min) {
  std::vector<Doubt> doubts;
  const CombinedEstimate all = combined(chains);
  doubt_values(doubts, all, chains.size(), k_chains, "");
  if (!(effective_size >= effective_size_min)) {
    doubts.push_back(
        {.kind = DoubtOf::few_draws,
         .reason = fmt::format(
             "the effective size of the weighted draws is {:.1f}, but at least {:.0f} is needed",
             effective_size, effective_size_min),
         .longer = effective_size_min / std::fmax(effective_size, 1),
         .at_least = true});
  }
  if (all.ladders == 0) return doubts;
  // The error of a log estimate is 1 / sqrt(effective size of the draws).
  double worth = 0;
  for (const LogEstimate& chain : chains) {
    if (std::isfinite(chain.value)) worth += 1 / (chain.error * chain.error);
  }
  if (worth < k_renewals_in_all) {
    doubts.push_back({.kind = DoubtOf::few_draws,
                      .reason = fmt::format("this estimate's draws have an effective size of "
                                            "{:.1f}, but at least {:.0f} is needed",
                                            worth, k_renewals_in_all),
                      .longer = k_renewals_in_all / std::fmax(worth, 1),
                      .at_least = true});
  }
  doubt_spread(doubts, all, k_chains);
  return doubts;
}

std::vector<Doubt> doubts_of_islands(const math::IslandOdds& islands, IslandNumber number,
                                     std::optional<double> particles) {
  std::vector<Doubt> doubts;
  if (const std::string reason = reason_not_sized(number); !reason.empty())
    doubts.push_back({.kind = DoubtOf::not_sized, .reason = reason, .at_least = true});
  if (!std::isfinite(islands.log_mean)) {
    doubts.push_back(
        {.kind = DoubtOf::no_value,
         .reason = fmt::format("none of {} islands has a value above 0", islands.islands),
         .at_least = true});
    return doubts;
  }
  const auto count = static_cast<double>(islands.islands);
  if (islands.islands < math::k_islands_min) {
    doubts.push_back({.kind = DoubtOf::few_draws,
                      .reason = fmt::format("there are {} islands, but at least {} are needed",
                                            islands.islands, math::k_islands_min),
                      .longer = static_cast<double>(math::k_islands_min) / count,
                      .at_least = true});
  }
  if (particles && *particles < k_particles_min) {
    doubts.push_back({.kind = DoubtOf::few_particles,
                      .reason = fmt::format(
                          "islands have {:.0f} particles, but at least {:.0f} "
                          "are needed; with fewer, islands usually miss the rare large weights",
                          *particles, k_particles_min),
                      .at_least = true});
  }
  if (islands.largest_share > math::k_largest_share_max) {
    doubts.push_back({.kind = DoubtOf::heavy_tail,
                      .reason = fmt::format("one of {} islands has {:.1f}% of the sum over all "
                                            "islands; at most {:.0f}% is allowed",
                                            islands.islands, 100 * islands.largest_share,
                                            100 * math::k_largest_share_max),
                      .longer = std::max(islands.largest_share / math::k_largest_share_max, 2.0),
                      .at_least = true});
  }
  return doubts;
}

Remedy remedy_of(std::span<const Doubt> doubts) {
  Remedy remedy;
  for (const Doubt& doubt : doubts) {
    remedy.longer = std::max(remedy.longer, doubt.longer);
    remedy.at_least = remedy.at_least || doubt.at_least;
  }
  return remedy;
}

}  // namespace sleight::analysis
