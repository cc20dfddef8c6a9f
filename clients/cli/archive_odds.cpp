#include "clients/cli/archive_odds.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "clients/cli/after_burn_in.h"
#include "clients/cli/sampling_method.h"
#include "clients/cli/tempering.h"

namespace sleight::cli {
namespace {

CombinedEstimate estimate_of(const archive::Source& source, const std::string& name,
                             std::uint64_t chains, std::size_t round) {
  const std::vector<double> values = of_ladders(source, name, chains, round);
  const std::vector<double> errors = of_ladders(source, name + "_error", chains, round);
  std::vector<LogEstimate> ladders;
  for (std::size_t i = 0; i < values.size(); ++i)
    ladders.push_back({.value = values[i], .error = errors[i]});
  return combined(ladders);
}

/// What annealed importance sampling's ascents say.
ArchiveOdds weighted_of(const archive::Source& source, std::uint64_t chains) {
  std::vector<LogEstimate> log_z;
  std::vector<LogEstimate> log_p;
  for (const AscentReport& chain : ascents_of(source, chains)) {
    log_z.push_back(chain.log_z);
    log_p.push_back(chain.log_p_satisfied);
  }
  return {.weighted = true,
          .log_z = combined(log_z),
          .log_p_satisfied = combined(log_p),
          .log_natural_throw = log_natural_throw(source)};
}

/// "-4.54 +- 0.02 (2 ladders, jackknife within ladders)"; weights are chains'.
std::string shown(const CombinedEstimate& estimate, bool weighted) {
  if (estimate.ladders == 0) return "unknown";
  const std::string from = fmt::format("{} {}{}", estimate.ladders, weighted ? "chain" : "ladder",
                                       estimate.ladders == 1 ? "" : "s");
  if (estimate.error_from == ErrorFrom::unknown) {
    return fmt::format("{:.2f} ({}, error unknown)", estimate.log.value, from);
  }
  return fmt::format("{:.2f} +- {:.2f} ({}, {})", estimate.log.value, estimate.log.error, from,
                     name_of(estimate.error_from, weighted));
}

}  // namespace

std::optional<ArchiveOdds> odds_of(const archive::Source& source, const archive::Summary& summary) {
  const auto method = method_of(summary.request_text);
  if (method == request::Method::annealed_importance) return weighted_of(source, summary.chains);
  const std::vector<Round> rounds =
      rounds_of(source, summary.chains,
                burns_in(method) ? std::nullopt : std::optional<std::uint64_t>(summary.scans));
  if (rounds.empty()) return std::nullopt;
  const auto estimate = [&](const std::string& name, std::size_t round) {
    return estimate_of(source, name, summary.chains, round);
  };
  const std::size_t judged = judged_round(rounds);
  ArchiveOdds tempered{.burn_in = burns_in(method),
                       .rounds = rounds.size(),
                       .judged = judged,
                       .log_z = estimate("log_z", judged),
                       .satisfied_round = judged,
                       .log_p_satisfied = estimate("log_p_satisfied", judged),
                       .log_natural_throw = log_natural_throw(source)};
  // Where nothing satisfied there, the latest of the other rounds must do.
  for (std::size_t r = rounds.size(); r-- > 0 && tempered.log_p_satisfied.ladders == 0;) {
    tempered.satisfied_round = r;
    tempered.log_p_satisfied = estimate("log_p_satisfied", r);
  }
  tempered.without_trips =
      without_round_trip(source, summary.chains, tempered.satisfied_round).size();
  return tempered;
}

std::string in_words(const ArchiveOdds& tempered, std::uint64_t chains) {
  std::string text;
  const auto round_of = [&](std::size_t round) {
    return fmt::format("round {} of {}{}", round + 1, tempered.rounds,
                       tempered.burn_in ? " of the burn-in" : "");
  };
  const auto from_round = [&](std::size_t round) {
    return tempered.weighted ? std::string() : ", " + round_of(round);
  };
  const CombinedEstimate& odds = tempered.log_p_satisfied;
  text += fmt::format("  log Z        {}{}\n", shown(tempered.log_z, tempered.weighted),
                      from_round(tempered.judged));
  if (odds.ladders == 0) {
    text += fmt::format("  by chance    unknown: nothing satisfied in any {}\n",
                        tempered.weighted ? "draw" : "round");
    return text;
  }
  text +=
      fmt::format("  by chance    {}\n", in_words(odds_of(odds.log, tempered.log_natural_throw)));
  text += fmt::format("               log P {}{}\n", shown(odds, tempered.weighted),
                      from_round(tempered.satisfied_round));
  if (tempered.satisfied_round != tempered.judged) {
    text += fmt::format("               of another round, since nothing satisfied in {}\n",
                        round_of(tempered.judged));
  }
  if (odds.ladders < chains) {
    text += fmt::format(
        "               nothing satisfied in {} of {} {}, which are left out: it may be rarer\n",
        chains - odds.ladders, chains, tempered.weighted ? "chains" : "ladders");
  }
  // Their states are still on their way, all of them on the same side: no spread shows that.
  if (tempered.without_trips > 0) {
    text += fmt::format(
        "               {} of {} ladders made no round trip in that round: it may be far off\n",
        tempered.without_trips, chains);
  }
  return text;
}

nlohmann::ordered_json as_json(const ArchiveOdds& tempered) {
  const ThrowOdds odds = odds_of(tempered.log_p_satisfied.log, tempered.log_natural_throw);
  const auto json_of = [&](const CombinedEstimate& estimate, std::size_t round) {
    nlohmann::ordered_json json{{"value", estimate.log.value},
                                {"error", estimate.log.error},
                                {"error_from", name_of(estimate.error_from, tempered.weighted)},
                                {"ladders", estimate.ladders}};
    if (!tempered.weighted) json["round"] = round + 1;
    return json;
  };
  nlohmann::ordered_json json{
      {"from", tempered.weighted  ? "weights"
               : tempered.burn_in ? "burn_in"
                                  : "ladders"},
      {"rounds", tempered.rounds},
      {"log_z", json_of(tempered.log_z, tempered.judged)},
      {"log_p_satisfied", json_of(tempered.log_p_satisfied, tempered.satisfied_round)},
      {"ladders_without_round_trip", tempered.without_trips},
      {"log_natural_throw", tempered.log_natural_throw},
      {"log10_throws", odds.log10_throws},
      {"log10_throws_low", odds.log10_low},
      {"log10_throws_high", odds.log10_high}};
  if (tempered.weighted) {
    json.erase("rounds");
    json.erase("ladders_without_round_trip");
  }
  return json;
}

}  // namespace sleight::cli
