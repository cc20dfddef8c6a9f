#include "clients/analysis/archive_odds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>

#include "clients/analysis/after_burn_in.h"
#include "clients/analysis/diagnosis.h"
#include "clients/analysis/request_numbers.h"
#include "clients/analysis/sampling_method.h"
#include "clients/analysis/tempering.h"
#include "common/request/direction_request.h"

namespace sleight::analysis {
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

/// Describes how a natural throw differs from a draw from the prior
/// (WorldLayout::log_natural_throw). The words fit any world.
std::string natural_throw_of(double log_natural_throw) {
  if (log_natural_throw == 0) return "";
  return log_natural_throw < 0 ? "a throw includes all bodies"
                               : "bodies are numbered before the throw";
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
      .from = OddsFrom::weights,
      .log_z = {.all = combined(log_z),
                .doubts = doubts_of_weights(log_z, size, k_effective_size_min)},
      .log_p_satisfied = {.all = combined(log_p),
                          .doubts = doubts_of_weights(log_p, size, k_effective_size_min)}};
  if (!odds.log_p_satisfied.known()) {
    const Remedy remedy = remedy_of(odds.log_p_satisfied.doubts);
    odds.how_to_know = {
        .longer = remedy.longer,
        .at_least = remedy.at_least,
        .besides =
            "a higher steps_per_level under [sampler] also helps, because the weights "
            "then differ less"};
  }
  return odds;
}

constexpr std::string_view k_island_log_z = "island_log_z";
constexpr std::string_view k_island_log_p = "island_log_satisfied";
/// Default of the suggested rule: P to a tenth.
constexpr double k_odds_asked_for = 0.1;

/// Returns a number of the request. Returns nothing if the request can't be read.
std::optional<double> number_of(const archive::Source& source, const archive::Summary& summary,
                                std::string_view section, std::string_view key) {
  if (!method_of(summary.request_text)) return std::nullopt;
  return RequestNumbers(summary.request_text, source.name()).find(section, key);
}

std::optional<double> stop_number(const archive::Source& source, const archive::Summary& summary,
                                  std::string_view key) {
  return number_of(source, summary, "stop", key);
}

IslandNumber island_number_of(const archive::Source& source, const archive::Summary& summary,
                              const ArchiveOdds& odds) {
  if (odds.odds_from_island) return IslandNumber::sized;
  if (odds.odds_until_island) return IslandNumber::fixed;
  if (!method_of(summary.request_text)) return IslandNumber::unknown;
  if (stop_number(source, summary, "odds")) return IslandNumber::unfinished;
  const bool by_solutions = stop_number(source, summary, "independent_solutions").has_value();
  return by_solutions ? IslandNumber::by_solutions : IslandNumber::fixed;
}

math::IslandOdds islands_in(const archive::Source& source, std::string_view name,
                            IslandRange islands) {
  math::IslandSums sums;
  for_each_of_islands(source, name, islands, [&](double log_estimate) { sums.add(log_estimate); });
  return sums.odds();
}

JudgedEstimate judge_islands(const archive::Source& source, std::string_view name,
                             const ArchiveOdds& odds, std::optional<double> particles) {
  const math::IslandOdds islands = islands_in(
      source, name, {.first = odds.odds_from_island.value_or(0), .end = odds.odds_until_island});
  return {.all = combined(islands),
          .doubts = doubts_of_islands(islands, odds.island_number, particles)};
}

/// Predicts the error of the sized round (IslandNumber::sized) from the islands before it. Returns
/// nothing if there is no such round, or if no prediction is possible.
std::optional<double> error_foretold(const archive::Source& source, const ArchiveOdds& odds) {
  const std::size_t sized = odds.log_p_satisfied.all.ladders;
  if (!odds.odds_from_island || sized == 0) return std::nullopt;
  const double error = islands_in(source, k_island_log_p, {.end = *odds.odds_from_island})
                           .log_error_of(static_cast<double>(sized));
  return std::isfinite(error) ? std::optional(error) : std::nullopt;
}

/// Rounds the suggested error down to two digits. An error rounded up might lead to a round of the
/// same size.
double error_to_ask_for(double error) {
  const double within = std::clamp(error, request::k_odds_min, request::k_odds_max);
  const double unit = std::pow(10, std::floor(std::log10(within)) - 1);
  return std::max(std::floor(within / unit) * unit, request::k_odds_min);
}

/// Suggests an error for the stop rule `odds`. If the islands were too few, the suggestion is
/// smaller than the requested error. Only an error below the predicted error makes the round
/// longer.
HowToKnow how_to_know_by_islands(const ArchiveOdds& odds, std::optional<double> asked_for,
                                 std::optional<double> foretold) {
  const std::vector<Doubt>& doubts = odds.log_p_satisfied.doubts;
  const Remedy remedy = remedy_of(doubts);
  const bool is_usable =
      asked_for && *asked_for >= request::k_odds_min && *asked_for <= request::k_odds_max;
  HowToKnow how{.longer = remedy.longer,
                .at_least = remedy.at_least,
                .odds = is_usable ? *asked_for : k_odds_asked_for};
  // Errors decrease with the square root of the number of islands.
  if (odds.island_number == IslandNumber::sized) {
    const double smaller = *how.odds / std::sqrt(remedy.longer);
    how.odds = error_to_ask_for(foretold ? std::min(smaller, 0.9 * *foretold) : smaller);
  }
  for (const Doubt& doubt : doubts) {
    if (doubt.kind == DoubtOf::heavy_tail || doubt.kind == DoubtOf::few_particles)
      how.besides =
          "more particles under [sampler] also help, because the islands' estimates then differ "
          "less";
  }
  return how;
}

/// Returns nothing if the archive has no islands.
std::optional<ArchiveOdds> islands_say(const archive::Source& source,
                                       const archive::Summary& summary) {
  const std::uint64_t chains = summary.chains;
  const auto islands = islands_of_chain(source, k_island_log_p, chains);
  const auto islands_of_z = islands_of_chain(source, k_island_log_z, chains);
  if (!islands || !islands_of_z) return std::nullopt;
  ArchiveOdds odds{.from = OddsFrom::islands};
  const std::uint64_t of_chain = std::min(*islands, *islands_of_z);
  odds.odds_from_island = island_of_all(source, "odds_from_island", chains, of_chain);
  odds.odds_until_island = island_of_all(source, "odds_until_island", chains, of_chain);
  odds.island_number = island_number_of(source, summary, odds);
  const std::optional<double> particles = number_of(source, summary, "sampler", "particles");
  odds.log_z = judge_islands(source, k_island_log_z, odds, particles);
  odds.log_p_satisfied = judge_islands(source, k_island_log_p, odds, particles);
  if (!odds.log_p_satisfied.known())
    odds.how_to_know = how_to_know_by_islands(odds, stop_number(source, summary, "odds"),
                                              error_foretold(source, odds));
  return odds;
}

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

struct Ladders {
  const archive::Source& source;
  const archive::Summary& summary;
  std::vector<Round> rounds;
  std::size_t judged = 0;
  std::string judged_name;  ///< such as "round 7 of 7"
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
  // If the judged round has no solution, use the latest round that has one.
  for (std::size_t r = ladders.rounds.size(); r-- > 0 && estimate.all.ladders == 0;) {
    estimate.round = r;
    estimate.all = combined(of_round(r));
  }
  return estimate;
}

/// Returns advice on request keys that lead to more round trips, except `rounds`.
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
        "more replicas under [sampler] also help, because the swap rates of this round allow "
        "only {:.1f} round trips",
        allowed);
  }
  if (allowed >= k_trips_each && allowed >= 2 * made) {
    return fmt::format(
        "a higher iterations_per_scan also helps, because the swap rates of this round allow "
        "{:.0f} round trips",
        allowed);
  }
  return "";
}

HowToKnow how_to_know(const Ladders& ladders, std::span<const Doubt> doubts) {
  const Remedy remedy = remedy_of(doubts);
  HowToKnow how{.longer = remedy.longer, .at_least = remedy.at_least};
  if (!method_of(ladders.summary.request_text)) return how;  // the request can't be read
  const RequestNumbers request(ladders.summary.request_text, ladders.source.name());
  if (std::ranges::find(doubts, DoubtOf::few_round_trips, &Doubt::kind) != doubts.end())
    how.besides = besides_rounds(ladders, request);
  const double first_round = request.find("sampler", "round_scans").value_or(0);
  if (!(first_round >= 1)) return how;

  // Count the doublings until a round has this length. At least one doubling is needed, because a
  // first round is always doubted.
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
                     odds.from == OddsFrom::burn_in ? " of the burn-in" : "");
}

bool has_rounds(OddsFrom from) {
  return from == OddsFrom::ladders || from == OddsFrom::burn_in;
}

const char* counted_by(OddsFrom from) {
  switch (from) {
    case OddsFrom::ladders:
    case OddsFrom::burn_in:
      return "ladder";
    case OddsFrom::weights:
      return "chain";
    case OddsFrom::islands:
      return "island";
  }
  return "ladder";
}

/// Returns nothing if the archive has no ladders.
std::optional<ArchiveOdds> ladders_say(const archive::Source& source,
                                       const archive::Summary& summary, bool burn_in) {
  std::vector<Round> rounds = rounds_of(
      source, summary.chains, burn_in ? std::nullopt : std::optional<std::uint64_t>(summary.scans));
  if (rounds.empty()) return std::nullopt;
  const std::size_t judged = judged_round(rounds);
  ArchiveOdds odds{.from = burn_in ? OddsFrom::burn_in : OddsFrom::ladders,
                   .rounds = rounds.size(),
                   .judged = judged};
  const Ladders ladders{.source = source,
                        .summary = summary,
                        .rounds = std::move(rounds),
                        .judged = judged,
                        .judged_name = round_name(judged, odds)};
  odds.log_z = judge(ladders, "log_z");
  odds.log_p_satisfied = judge(ladders, "log_p_satisfied");
  odds.without_trips = without_round_trip(source, summary.chains, judged).size();
  if (!odds.log_p_satisfied.known())
    odds.how_to_know = how_to_know(ladders, odds.log_p_satisfied.doubts);
  return odds;
}

/// Returns, for example, "-4.54 +- 0.02 (2 ladders, jackknife within ladders), round 7 of 7".
std::string estimate_text(const JudgedEstimate& estimate, double log_of_unit,
                          const ArchiveOdds& odds) {
  const CombinedEstimate& all = estimate.all;
  if (all.ladders == 0) return "unknown";
  const double value = all.log.value - log_of_unit;
  const std::string from =
      fmt::format("{} {}{}", all.ladders, counted_by(odds.from), all.ladders == 1 ? "" : "s");
  const std::string round =
      has_rounds(odds.from) ? fmt::format(", {}", round_name(estimate.round, odds)) : "";
  if (!estimate.known()) return fmt::format("{:.2f}, error unknown ({}){}", value, from, round);
  return fmt::format("{:.2f} +- {:.2f} ({}, {}){}", value, all.log.error, from,
                     name_of(all.error_from, odds.from == OddsFrom::weights), round);
}

void add_doubts(std::span<const Doubt> doubts, report::Report& report) {
  for (const Doubt& doubt : doubts)
    report.for_people("", doubt.reason);
}

void add_remedy(const HowToKnow& how, const ArchiveOdds& odds, report::Report& report) {
  std::string what;
  if (how.odds) {
    what = fmt::format("set odds = {:.2g} as the only rule under [stop]", *how.odds);
  } else if (!how.rounds) {
    what = fmt::format("{:.1f} times as many scans", how.longer);
  } else if (odds.from == OddsFrom::burn_in) {
    what = fmt::format("burn_in_rounds = {} under [sampler]", *how.rounds);
  } else {
    what = fmt::format("rounds = {} under [stop]", *how.rounds);
  }
  std::string words = fmt::format("to determine the odds: {}{}",
                                  how.at_least && !how.odds ? "at least " : "", what);
  if (how.scans) words += fmt::format(" ({} scans per ladder)", *how.scans);
  report.for_people("", words);
  report.for_people("", how.besides);
}

const char* place_word(OddsFrom from) {
  if (from == OddsFrom::weights) return "draw";
  return from == OddsFrom::islands ? "island" : "round";
}

/// Returns ", where a throw includes all bodies". Empty if a throw is a draw from the prior.
std::string where_throws(const ArchiveOdds& odds) {
  return odds.natural_throw.empty() ? "" : ", where " + odds.natural_throw;
}

/// Describes how an untrusted estimate may be wrong.
const char* caution_of(const ArchiveOdds& odds) {
  if (has_rounds(odds.from)) return "this estimate is usually too low until the ladders have mixed";
  if (odds.from == OddsFrom::weights)
    return "this estimate is usually too low if a few draws have all the weight";
  const std::vector<Doubt>& doubts = odds.log_p_satisfied.doubts;
  if (std::ranges::find(doubts, DoubtOf::not_sized, &Doubt::kind) != doubts.end())
    return "this estimate depends on when the run ended";
  return "this estimate is usually too low if a few islands make up most of the sum";
}

void add_unknown(const ArchiveOdds& odds, report::Report& report) {
  const JudgedEstimate& log_p = odds.log_p_satisfied;
  const bool is_none = log_p.all.ladders == 0;
  report.for_people(
      "by chance",
      is_none ? fmt::format("unknown: no solution in any {}", place_word(odds.from)) : "unknown");
  add_doubts(log_p.doubts, report);
  if (odds.how_to_know) add_remedy(*odds.how_to_know, odds, report);
  if (is_none) return;
  report.for_people(
      "", fmt::format("so far log P {}{}", estimate_text(log_p, odds.log_natural_throw, odds),
                      where_throws(odds)));
  report.for_people("", caution_of(odds));
}

const char* name_of(OddsFrom from) {
  switch (from) {
    case OddsFrom::ladders:
      return "ladders";
    case OddsFrom::burn_in:
      return "burn_in";
    case OddsFrom::weights:
      return "weights";
    case OddsFrom::islands:
      return "islands";
  }
  return "ladders";
}

json::Value as_json(const JudgedEstimate& estimate, double log_of_unit, OddsFrom from) {
  const CombinedEstimate& all = estimate.all;
  const bool known = estimate.known();
  json::Value json{{"value", all.log.value - log_of_unit},
                   {"error", known ? json::Value(all.log.error) : json::Value(nullptr)},
                   {"error_from", name_of(known ? all.error_from : ErrorFrom::unknown,
                                          from == OddsFrom::weights)},
                   {from == OddsFrom::islands ? "islands" : "ladders", all.ladders}};
  if (has_rounds(from)) json["round"] = estimate.round + 1;
  json["doubts"] = json::Value::array();
  for (const Doubt& doubt : estimate.doubts)
    json["doubts"].push_back(doubt.reason);
  return json;
}

}  // namespace

std::optional<ArchiveOdds> odds_of(const archive::Source& source, const archive::Summary& summary) {
  const auto method = method_of(summary.request_text);
  std::optional<ArchiveOdds> odds = method == request::Method::annealed_importance
                                        ? weighted_of(source, summary.chains)
                                        : islands_say(source, summary);
  if (!odds) odds = ladders_say(source, summary, burns_in(method));
  if (!odds) return std::nullopt;
  odds->log_natural_throw = log_natural_throw(source);
  odds->natural_throw = natural_throw_of(odds->log_natural_throw);
  return odds;
}

void add_odds(const ArchiveOdds& odds, report::Report& report) {
  const JudgedEstimate& log_p = odds.log_p_satisfied;
  report.add("tempering", as_json(odds), "log Z", estimate_text(odds.log_z, 0, odds));
  if (!log_p.known()) return add_unknown(odds, report);
  // If log P is unknown too, add_unknown() explains both unknown values.
  add_doubts(odds.log_z.doubts, report);
  report.for_people("by chance",
                    in_words(odds_of(log_p.all.log, odds.log_natural_throw)) + where_throws(odds));
  report.for_people("", "log P " + estimate_text(log_p, odds.log_natural_throw, odds));
}

json::Value as_json(const ArchiveOdds& odds) {
  const JudgedEstimate& log_p = odds.log_p_satisfied;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ThrowOdds throws =
      log_p.known() ? odds_of(log_p.all.log, odds.log_natural_throw) : ThrowOdds{nan, nan, nan};
  json::Value json{{"from", name_of(odds.from)},
                   {"rounds", odds.rounds},
                   {"log_z", as_json(odds.log_z, 0, odds.from)},
                   {"log_p_satisfied", as_json(log_p, 0, odds.from)},
                   {"log_p_throw", as_json(log_p, odds.log_natural_throw, odds.from)},
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
    if (how.odds) json["to_know"]["odds"] = *how.odds;
  }
  if (!has_rounds(odds.from)) {
    json.erase("rounds");
    json.erase("ladders_without_round_trip");
  }
  if (odds.odds_from_island) json["odds_from_island"] = *odds.odds_from_island;
  if (odds.odds_until_island) json["odds_until_island"] = *odds.odds_until_island;
  return json;
}

}  // namespace sleight::analysis
