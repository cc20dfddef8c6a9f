#include "clients/cli/archive_odds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>

#include "clients/cli/after_burn_in.h"
#include "clients/cli/diagnosis.h"
#include "clients/cli/request_numbers.h"
#include "clients/cli/sampling_method.h"
#include "clients/cli/tempering.h"
#include "common/request/direction_request.h"

namespace sleight::cli {
namespace {

std::vector<LogEstimate> estimates_of(const archive::Source& source, const std::string& name,
                                      std::uint64_t chains, std::size_t round) {
  const std::vector<double> values = of_ladders(source, name, chains, round);
  const std::vector<double> errors = of_ladders(source, name + "_error", chains, round);
  std::vector<LogEstimate> ladders;
  for (std::size_t i = 0; i < values.size(); ++i)
    ladders.push_back({.value = values[i], .error = errors[i]});
  return ladders;
}

/// What the throw is whose odds are told, where it is no draw from the prior.
std::string natural_throw_of(std::string_view world, double log_natural_throw) {
  if (log_natural_throw == 0) return "";
  if (world == "spelling") return "a throw drops all balls";
  if (world == "dice") return "a throw's dice are numbered before it";
  return "a throw is what a person can make blindly";
}

ArchiveOdds weighted_of(const archive::Source& source, std::uint64_t chains) {
  std::vector<LogEstimate> log_z;
  std::vector<LogEstimate> log_p;
  for (const AscentReport& chain : ascents_of(source, chains)) {
    log_z.push_back(chain.log_z);
    log_p.push_back(chain.log_p_satisfied);
  }
  const double size = effective_size_of_all(source);
  ArchiveOdds odds{
      .weighted = true,
      .log_z = {.all = combined(log_z),
                .doubts = doubts_of_weights(log_z, size, k_effective_size_min)},
      .log_p_satisfied = {.all = combined(log_p),
                          .doubts = doubts_of_weights(log_p, size, k_effective_size_min)}};
  if (!odds.log_p_satisfied.known()) {
    const Remedy remedy = remedy_of(odds.log_p_satisfied.doubts);
    odds.how_to_know = {.longer = remedy.longer,
                        .at_least = remedy.at_least,
                        .besides = "more steps_per_level under [sampler] makes weights more equal"};
  }
  return odds;
}

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Ladders in an archive, as odds are made of them.
struct Ladders {
  const archive::Source& source;
  const archive::Summary& summary;
  std::vector<Round> rounds;
  std::size_t judged = 0;
  std::string judged_name;  ///< "round 7 of 7"
};

JudgedEstimate judge(const Ladders& ladders, const std::string& name) {
  const std::uint64_t chains = ladders.summary.chains;
  const auto of_round = [&](std::size_t round) {
    return estimates_of(ladders.source, name, chains, round);
  };
  LadderFacts facts{
      .judged = of_round(ladders.judged),
      .before = {},
      .round_trips = of_ladders(ladders.source, "round_trips", chains, ladders.judged),
      .round = ladders.judged_name};
  if (ladders.judged > 0) facts.before = of_round(ladders.judged - 1);
  JudgedEstimate estimate{
      .all = combined(facts.judged), .round = ladders.judged, .doubts = doubts_of(facts)};
  // Where nothing satisfied there, the latest of the other rounds must do.
  for (std::size_t r = ladders.rounds.size(); r-- > 0 && estimate.all.ladders == 0;) {
    estimate.round = r;
    estimate.all = combined(of_round(r));
  }
  return estimate;
}

/// Which keys help besides more rounds, where round trips are too few.
std::string besides_rounds(const Ladders& ladders, const RequestNumbers& request) {
  const std::uint64_t chains = ladders.summary.chains;
  const auto numbers = [&](const char* name) {
    return of_ladders(ladders.source, name, chains, ladders.judged);
  };
  const double made = mean_of(numbers("round_trips"));
  const double allowed = mean_of(numbers("predicted_round_trip_rate")) *
                         static_cast<double>(ladders.rounds[ladders.judged].scans);
  if (allowed < k_trips_each && request.find("sampler", "replicas")) {
    return fmt::format(
        "more replicas under [sampler] help too: swaps alone allow only {:.1f} round trips",
        allowed);
  }
  if (allowed >= k_trips_each && allowed >= 2 * made) {
    return fmt::format(
        "more iterations_per_scan helps too: swaps alone would allow {:.0f} round trips", allowed);
  }
  return "";
}

HowToKnow how_to_know(const Ladders& ladders, std::span<const Doubt> doubts) {
  const Remedy remedy = remedy_of(doubts);
  HowToKnow how{.longer = remedy.longer, .at_least = remedy.at_least};
  if (!method_of(ladders.summary.request_text)) return how;  // no request that is known here
  const RequestNumbers request(ladders.summary.request_text, ladders.source.name());
  if (std::ranges::find(doubts, DoubtOf::few_round_trips, &Doubt::kind) != doubts.end())
    how.besides = besides_rounds(ladders, request);
  const double first_round = request.find("sampler", "round_scans").value_or(0);
  if (!(first_round >= 1)) return how;

  // Rounds double, and one has to be so long. The first is never judged alone.
  const double length = static_cast<double>(ladders.rounds[ladders.judged].scans) * remedy.longer;
  const double doublings = std::max(std::ceil(std::log2(length / first_round)), 1.0);
  if (doublings + 1 > request::k_rounds_max) return how;
  how.rounds = static_cast<std::uint32_t>(doublings) + 1;
  const auto scans = static_cast<double>(ladders.rounds[0].first_scan) +
                     first_round * (std::exp2(*how.rounds) - 1);
  if (scans <= static_cast<double>(request::k_scans_max))
    how.scans = static_cast<std::uint64_t>(scans);
  return how;
}

std::string round_name(std::size_t round, const ArchiveOdds& odds) {
  return fmt::format("round {} of {}{}", round + 1, odds.rounds,
                     odds.burn_in ? " of the burn-in" : "");
}

/// "-4.54 +- 0.02 (2 ladders, jackknife within ladders), round 7 of 7"; weights are chains'.
std::string shown(const JudgedEstimate& estimate, double log_of_unit, const ArchiveOdds& odds) {
  const CombinedEstimate& all = estimate.all;
  if (all.ladders == 0) return "unknown";
  const double value = all.log.value - log_of_unit;
  const std::string from = fmt::format("{} {}{}", all.ladders, odds.weighted ? "chain" : "ladder",
                                       all.ladders == 1 ? "" : "s");
  const std::string round =
      odds.weighted ? "" : fmt::format(", {}", round_name(estimate.round, odds));
  if (!estimate.known()) return fmt::format("{:.2f}, error unknown ({}){}", value, from, round);
  return fmt::format("{:.2f} +- {:.2f} ({}, {}){}", value, all.log.error, from,
                     name_of(all.error_from, odds.weighted), round);
}

constexpr const char* k_indent = "               ";

std::string lines_of(std::span<const Doubt> doubts) {
  std::string text;
  for (const Doubt& doubt : doubts)
    text += fmt::format("{}{}\n", k_indent, doubt.reason);
  return text;
}

std::string in_words(const HowToKnow& how, const ArchiveOdds& odds) {
  std::string what;
  if (!how.rounds) {
    what = fmt::format("{:.1f} times as many scans", how.longer);
  } else if (odds.burn_in) {
    what = fmt::format("burn_in_rounds = {} under [sampler]", *how.rounds);
  } else {
    what = fmt::format("rounds = {} under [stop]", *how.rounds);
  }
  std::string text =
      fmt::format("{}to know it: {}{}", k_indent, how.at_least ? "at least " : "", what);
  if (how.scans) text += fmt::format(" ({} scans of each ladder)", *how.scans);
  text += "\n";
  if (!how.besides.empty()) text += fmt::format("{}{}\n", k_indent, how.besides);
  return text;
}

/// Of an estimate whose error can't be trusted.
std::string unknown_in_words(const ArchiveOdds& odds) {
  const JudgedEstimate& log_p = odds.log_p_satisfied;
  std::string text = "  by chance    unknown";
  if (log_p.all.ladders == 0)
    text += fmt::format(": nothing satisfied in any {}", odds.weighted ? "draw" : "round");
  text += "\n";
  text += lines_of(log_p.doubts);
  if (odds.how_to_know) text += in_words(*odds.how_to_know, odds);
  if (log_p.all.ladders == 0) return text;
  text +=
      fmt::format("{}so far log P {}{}{}\n", k_indent, shown(log_p, odds.log_natural_throw, odds),
                  odds.natural_throw.empty() ? "" : ", where ", odds.natural_throw);
  text += fmt::format(
      "{}which mostly is too low {}\n", k_indent,
      odds.weighted ? "where few draws have all the weight" : "while ladders have not mixed");
  return text;
}

nlohmann::ordered_json as_json(const JudgedEstimate& estimate, double log_of_unit, bool weighted) {
  const CombinedEstimate& all = estimate.all;
  const bool known = estimate.known();
  nlohmann::ordered_json json{
      {"value", all.log.value - log_of_unit},
      {"error", known ? nlohmann::ordered_json(all.log.error) : nlohmann::ordered_json(nullptr)},
      {"error_from", name_of(known ? all.error_from : ErrorFrom::unknown, weighted)},
      {"ladders", all.ladders}};
  if (!weighted) json["round"] = estimate.round + 1;
  json["doubts"] = nlohmann::ordered_json::array();
  for (const Doubt& doubt : estimate.doubts)
    json["doubts"].push_back(doubt.reason);
  return json;
}

}  // namespace

std::optional<ArchiveOdds> odds_of(const archive::Source& source, const archive::Summary& summary) {
  const auto method = method_of(summary.request_text);
  std::optional<ArchiveOdds> odds;
  if (method == request::Method::annealed_importance) {
    odds = weighted_of(source, summary.chains);
  } else {
    std::vector<Round> rounds =
        rounds_of(source, summary.chains,
                  burns_in(method) ? std::nullopt : std::optional<std::uint64_t>(summary.scans));
    if (rounds.empty()) return std::nullopt;
    const std::size_t judged = judged_round(rounds);
    odds = {.burn_in = burns_in(method), .rounds = rounds.size(), .judged = judged};
    const Ladders ladders{.source = source,
                          .summary = summary,
                          .rounds = std::move(rounds),
                          .judged = judged,
                          .judged_name = round_name(judged, *odds)};
    odds->log_z = judge(ladders, "log_z");
    odds->log_p_satisfied = judge(ladders, "log_p_satisfied");
    odds->without_trips = without_round_trip(source, summary.chains, judged).size();
    if (!odds->log_p_satisfied.known())
      odds->how_to_know = how_to_know(ladders, odds->log_p_satisfied.doubts);
  }
  odds->log_natural_throw = log_natural_throw(source);
  odds->natural_throw = natural_throw_of(summary.world, odds->log_natural_throw);
  return odds;
}

std::string in_words(const ArchiveOdds& odds) {
  std::string text = fmt::format("  log Z        {}\n", shown(odds.log_z, 0, odds));
  if (!odds.log_p_satisfied.known()) return text + unknown_in_words(odds);
  // Where log P is not known, the lines below it say why of both.
  text += lines_of(odds.log_z.doubts);
  text += fmt::format("  by chance    {}{}{}\n",
                      in_words(odds_of(odds.log_p_satisfied.all.log, odds.log_natural_throw)),
                      odds.natural_throw.empty() ? "" : ", where ", odds.natural_throw);
  text += fmt::format("{}log P {}\n", k_indent,
                      shown(odds.log_p_satisfied, odds.log_natural_throw, odds));
  return text;
}

nlohmann::ordered_json as_json(const ArchiveOdds& odds) {
  const JudgedEstimate& log_p = odds.log_p_satisfied;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ThrowOdds throws =
      log_p.known() ? odds_of(log_p.all.log, odds.log_natural_throw) : ThrowOdds{nan, nan, nan};
  nlohmann::ordered_json json{
      {"from", odds.weighted  ? "weights"
               : odds.burn_in ? "burn_in"
                              : "ladders"},
      {"rounds", odds.rounds},
      {"log_z", as_json(odds.log_z, 0, odds.weighted)},
      {"log_p_satisfied", as_json(log_p, 0, odds.weighted)},
      {"log_p_throw", as_json(log_p, odds.log_natural_throw, odds.weighted)},
      {"ladders_without_round_trip", odds.without_trips},
      {"log_natural_throw", odds.log_natural_throw},
      {"natural_throw", odds.natural_throw},
      {"known", log_p.known()},
      {"log10_throws", throws.log10_throws},
      {"log10_throws_low", throws.log10_low},
      {"log10_throws_high", throws.log10_high},
      {"to_know", nullptr}};
  if (odds.how_to_know) {
    const HowToKnow& how = *odds.how_to_know;
    json["to_know"] = {{"longer", how.longer}, {"at_least", how.at_least}};
    if (how.rounds) json["to_know"]["rounds"] = *how.rounds;
    if (how.scans) json["to_know"]["scans"] = *how.scans;
  }
  if (odds.weighted) {
    json.erase("rounds");
    json.erase("ladders_without_round_trip");
  }
  return json;
}

}  // namespace sleight::cli
