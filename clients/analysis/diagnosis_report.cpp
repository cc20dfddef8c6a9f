#include "clients/analysis/diagnosis_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "clients/report/report.h"

namespace sleight::analysis {
namespace {

using Json = json::Value;

/// Limits on what the report shows: ladders with their levels, temperatures in a row, reasons,
/// chains.
constexpr std::size_t k_ladders_shown = 2;
constexpr std::size_t k_columns_shown = 8;
constexpr std::size_t k_reasons_shown = 20;
constexpr std::size_t k_chains_shown = 32;

std::string number(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.4g}", value);
}

std::string fixed(double value, int decimals) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, decimals);
}

std::string percent(double share) {
  return std::isnan(share) ? "-" : fmt::format("{:.1f}%", 100 * share);
}

/// Returns "12,345", or "1.2e+20" for large numbers.
std::string count(double value) {
  if (std::isnan(value)) return "-";
  if (!(std::fabs(value) < 1e15)) return number(value);
  std::string digits = fmt::format("{:.0f}", std::floor(value));
  for (std::size_t place = digits.size(); place > 3; place -= 3)
    digits.insert(place - 3, 1, ',');
  return digits;
}

std::string count(std::uint64_t value) {
  return count(static_cast<double>(value));
}

double share_of(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

report::Report report_of(const ScalarReport& scalar) {
  const Verdict& verdict = scalar.verdict;
  std::string remark;
  if (!verdict.complaints.empty()) remark = "<- not mixed";
  if (verdict.constant) remark = "never changes";
  const auto note = [&](std::uint64_t times, std::string_view what) {
    if (times == 0) return;
    remark += fmt::format("{}{} {}", remark.empty() ? "" : "; ", count(times), what);
  };
  note(scalar.not_finite.minus_infinite, "are -inf");
  note(scalar.not_finite.nan, "are not applicable");
  report::Report report;
  report.add("name", scalar.name, "", scalar.name);
  report.add("mean", verdict.mean, "mean", number(verdict.mean));
  report.add("sd", verdict.sd, "sd", number(verdict.sd));
  report.add("mcse_mean", verdict.mcse, "MCSE", number(verdict.mcse));
  report.add("r_hat", verdict.r_hat, "R-hat", fixed(verdict.r_hat, 3));
  report.add("ess_bulk", verdict.ess_bulk, "bulk ESS", count(verdict.ess_bulk));
  report.add("ess_tail", verdict.ess_tail, "tail ESS", count(verdict.ess_tail));
  report.for_programs("constant", verdict.constant);
  report.for_programs("minus_infinite", scalar.not_finite.minus_infinite);
  report.for_programs("not_applicable", scalar.not_finite.nan);
  report.for_programs("complaints", verdict.complaints);
  report.for_people("", remark);
  return report;
}

report::Report report_of(const KindReport& kind) {
  report::Report report;
  report.add("name", kind.name, "", kind.name);
  report.add("proposed", kind.proposed, "proposed", count(kind.proposed));
  report.add("accepted", kind.accepted, "accepted", count(kind.accepted));
  report.for_people("rate", percent(share_of(kind.accepted, kind.proposed)));
  return report;
}

double least(const std::vector<double>& values) {
  double found = std::numeric_limits<double>::quiet_NaN();
  for (const double value : values) {
    if (!(value >= found)) found = value;
  }
  return found;
}

report::Report report_of(const LadderReport& ladder, std::size_t index) {
  const Ladder& levels = ladder.levels;
  report::Report report;
  report.for_people("", fmt::format("ladder {}", index));
  report.for_people("temperatures", count(levels.inverse_temperature.size()));
  report.add("barrier", ladder.barrier, "barrier", fixed(ladder.barrier, 2));
  report.for_people("lowest swap rate", percent(least(levels.swap_acceptance)));
  report.add("round_trips", ladder.round_trips, "round trips", count(ladder.round_trips));
  report.add("predicted_round_trips", ladder.predicted_round_trips, "predicted",
             fixed(ladder.predicted_round_trips, 1));
  report.add("restarts", ladder.restarts, "restarts", count(ladder.restarts));
  report.for_programs("inverse_temperature", levels.inverse_temperature);
  report.for_programs("swap_acceptance", levels.swap_acceptance);
  report.for_programs("local_barrier", levels.local_barrier);
  report.for_programs("acceptance", levels.acceptance);
  return report;
}

report::Report report_of(const WalkReport& walk, std::size_t index) {
  std::vector<double> moves = walk.acceptance;
  if (!moves.empty()) moves.pop_back();  // the coldest level has no next one
  const double scans = std::accumulate(walk.visits.begin(), walk.visits.end(), 0.0);
  report::Report report;
  report.for_people("", fmt::format("chain {}", index));
  report.for_people("temperatures", count(walk.inverse_temperature.size()));
  report.add("round_trips", walk.round_trips, "round trips", count(walk.round_trips));
  report.for_people("lowest visit rate", percent(least(walk.visits) / scans));
  report.for_people("lowest move rate", percent(least(moves)));
  report.for_programs("inverse_temperature", walk.inverse_temperature);
  report.for_programs("visits", walk.visits);
  report.for_programs("acceptance", walk.acceptance);
  return report;
}

report::Report report_of(const TransitionReport& chain, std::size_t index) {
  report::Report report;
  report.for_people("", fmt::format("chain {}", index));
  report.add("temperatures", chain.levels, "temperatures", count(chain.levels));
  report.add("acceptance", chain.acceptance, "accepted", percent(chain.acceptance));
  return report;
}

std::string with_error(const LogEstimate& estimate) {
  return fmt::format("{} +- {}", fixed(estimate.value, 3), fixed(estimate.error, 3));
}

Json as_json(const LogEstimate& estimate) {
  return {{"value", estimate.value}, {"error", estimate.error}};
}

report::Report report_of_draws(const std::string& name, std::uint64_t draws,
                               const AscentReport& chain) {
  report::Report report;
  report.for_people("", name);
  report.for_people("draws", count(draws));
  report.add("effective_size", chain.effective_size, "effective size",
             fixed(chain.effective_size, 1));
  report.add("steps", chain.steps, "steps", count(chain.steps));
  report.add("log_z", as_json(chain.log_z), "log Z", with_error(chain.log_z));
  report.add("log_p_satisfied", as_json(chain.log_p_satisfied), "log P(satisfied)",
             with_error(chain.log_p_satisfied));
  return report;
}

constexpr auto k_report_of = [](const auto& record) { return report_of(record); };
constexpr auto k_numbered_report_of = [](const auto& record, std::size_t index) {
  return report_of(record, index);
};

void append_variables(std::string& text, const Diagnosis& diagnosis) {
  if (diagnosis.variables.empty()) return;
  text += fmt::format("\nState variables, from {} archived states per chain\n",
                      count(diagnosis.states));
  std::vector<ScalarReport> listed;
  std::vector<std::string> rest;
  for (const VariableReport& variable : diagnosis.variables) {
    listed.insert(listed.end(), variable.listed.begin(), variable.listed.end());
    const std::uint64_t shown = variable.listed.size();
    if (shown == variable.judged) continue;
    rest.push_back(fmt::format("{}: the worst {} of {} entries are shown; {} have not mixed",
                               variable.name, shown, count(variable.judged),
                               variable.failing == 0 ? "none" : count(variable.failing)));
  }
  text += report::indented_table(report::reports_of(listed, k_report_of));
  for (const std::string& line : rest)
    text += fmt::format("  {}\n", line);
}

void append_counts(std::string& text, const Diagnosis& diagnosis) {
  const std::uint64_t judged = diagnosis.chains * diagnosis.judged.scans;
  text += "\n";
  text += fmt::format("  satisfied  in {} of the judged scans and in {} of all scans{}\n",
                      percent(share_of(diagnosis.satisfied_judged, judged)),
                      percent(share_of(diagnosis.satisfied, diagnosis.chains * diagnosis.scans)),
                      diagnosis.weights ? ", regardless of weights" : "");
  text += fmt::format("  solutions  {}{} independent (one per lineage with a satisfied scan)\n",
                      count(diagnosis.solutions), diagnosis.solutions_more ? " or more" : "");
  if (std::isnan(diagnosis.simulations)) return;
  text +=
      fmt::format("  simulated  {} (proposals and draws from the prior{})\n",
                  count(diagnosis.simulations), diagnosis.tempering ? ", at all temperatures" : "");
}

void append_kinds(std::string& text, const Diagnosis& diagnosis) {
  text += fmt::format("\nAcceptance in the judged scans{}\n",
                      diagnosis.tempering ? ", at inverse temperature 1" : "");
  text += report::indented_table(report::reports_of(diagnosis.kinds, k_report_of));
}

void append_ladders(std::string& text, const TemperingReport& tempering) {
  text += fmt::format("\nLadders in round {} of {}{}\n", tempering.round, tempering.rounds,
                      tempering.burn_in ? " of the burn-in" : "");
  text += report::indented_table(report::reports_of(tempering.ladders, k_numbered_report_of));
}

void append_levels(std::string& text, const Ladder& ladder, std::size_t index) {
  text += fmt::format("\nLadder {} by inverse temperature, starting at the prior\n", index);
  std::vector<report::Report> rows;
  for (std::size_t level = 0; level < ladder.inverse_temperature.size(); ++level) {
    const bool has_next = level < ladder.swap_acceptance.size();
    report::Report& row = rows.emplace_back();
    row.for_people("", fmt::format("level {}", level));
    row.for_people("inverse temperature", number(ladder.inverse_temperature[level]));
    row.for_people("swaps with next level", has_next ? percent(ladder.swap_acceptance[level]) : "");
    row.for_people("local barrier", number(ladder.local_barrier[level]));
  }
  text += report::indented_table(rows);
}

/// Appends a table of acceptance by proposal kind and temperature. The first and the last
/// temperature are always shown.
void append_acceptance(std::string& text, const Diagnosis& diagnosis, const Ladder& ladder,
                       std::size_t index) {
  const std::size_t levels = ladder.acceptance.size();
  if (levels == 0) return;
  const std::size_t columns = std::min(levels, k_columns_shown);
  text += fmt::format("\nAcceptance on ladder {} by inverse temperature{}\n", index,
                      columns < levels ? fmt::format(", {} of {}", columns, levels) : "");
  std::vector<report::Report> rows;
  for (std::size_t k = 0; k < diagnosis.kinds.size(); ++k) {
    rows.emplace_back().for_people("", diagnosis.kinds[k].name);
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t level = columns == 1 ? 0 : column * (levels - 1) / (columns - 1);
      const std::vector<double>& of_level = ladder.acceptance[level];
      rows.back().for_people(fmt::format("{:.3g}", ladder.inverse_temperature[level]),
                             k < of_level.size() ? percent(of_level[k]) : "-");
    }
  }
  text += report::indented_table(rows);
}

void append_tempering(std::string& text, const Diagnosis& diagnosis) {
  const TemperingReport& tempering = *diagnosis.tempering;
  append_ladders(text, tempering);
  const std::size_t shown = std::min(tempering.ladders.size(), k_ladders_shown);
  for (std::size_t i = 0; i < shown; ++i) {
    append_levels(text, tempering.ladders[i].levels, i);
    append_acceptance(text, diagnosis, tempering.ladders[i].levels, i);
  }
  if (shown < tempering.ladders.size()) {
    text += fmt::format("\n  {} more ladders not shown (--json shows all)\n",
                        tempering.ladders.size() - shown);
  }
}

void append_walks(std::string& text, const std::vector<WalkReport>& walks) {
  if (walks.empty()) return;
  text += "\nWalks over temperatures\n";
  text += report::indented_table(report::reports_of(walks, k_numbered_report_of));
  const std::size_t shown = std::min(walks.size(), k_ladders_shown);
  for (std::size_t i = 0; i < shown; ++i) {
    text += fmt::format(
        "\nWalk of chain {}, one line per inverse temperature, starting at the prior\n", i);
    std::vector<report::Report> levels;
    for (std::size_t level = 0; level < walks[i].visits.size(); ++level) {
      const bool has_next = level + 1 < walks[i].visits.size();
      report::Report& row = levels.emplace_back();
      row.for_people("", fmt::format("level {}", level));
      row.for_people("inverse temperature", number(walks[i].inverse_temperature[level]));
      row.for_people("scans", count(walks[i].visits[level]));
      row.for_people("moves to the next level and back",
                     has_next ? percent(walks[i].acceptance[level]) : "");
    }
    text += report::indented_table(levels);
  }
}

void append_transitions(std::string& text, const std::vector<TransitionReport>& transitions) {
  if (transitions.empty()) return;
  text += "\nTempered transitions\n";
  text += report::indented_table(report::reports_of(transitions, k_numbered_report_of));
}

void append_weights(std::string& text, const Diagnosis& diagnosis) {
  const WeightsReport& weights = *diagnosis.weights;
  text += "Independent weighted draws\n";
  std::vector<report::Report> rows;
  const std::size_t shown = std::min(weights.chains.size(), k_chains_shown);
  for (std::size_t i = 0; i < shown; ++i)
    rows.push_back(report_of_draws(fmt::format("chain {}", i), diagnosis.scans, weights.chains[i]));
  rows.push_back(report_of_draws("all", diagnosis.chains * diagnosis.scans,
                                 {.effective_size = weights.effective_size,
                                  .steps = k_not_known,
                                  .log_z = weights.log_z.log,
                                  .log_p_satisfied = weights.log_p_satisfied.log}));
  text += report::indented_table(rows);
  if (shown < weights.chains.size())
    text += fmt::format("  {} more chains not shown (--json shows all)\n",
                        weights.chains.size() - shown);
}

const char* name_of(JudgedDraws which) {
  switch (which) {
    case JudgedDraws::second_half:
      return "second_half";
    case JudgedDraws::round:
      return "round";
    case JudgedDraws::all:
      return "all";
    case JudgedDraws::tours:
      return "tours";
    case JudgedDraws::weighted:
      return "weighted";
  }
  return "";
}

const char* in_words(JudgedDraws which) {
  switch (which) {
    case JudgedDraws::second_half:
      return "the second half";
    case JudgedDraws::round:
      return "one round, in which the ladder and proposal sizes are constant";
    case JudgedDraws::all:
      return "all scans after the burn-in";
    case JudgedDraws::tours:
      return "the last scan of each tour";
    case JudgedDraws::weighted:
      return "all, with their weights";
  }
  return "";
}

void append_verdict(std::string& text, const Diagnosis& diagnosis) {
  for (const std::string& note : diagnosis.notes)
    text += fmt::format("\nNote: {}.\n", note);
  const bool weighted = diagnosis.weights.has_value();
  if (diagnosis.mixed()) {
    text += weighted ? "\n"
                       "The effective size of the weighted draws is large enough.\n"
                     : "\nAll checks passed: they found no sign of poor mixing.\n";
    return;
  }
  const bool of_tours = diagnosis.which == JudgedDraws::tours;
  text += weighted   ? "\n"
                       "The effective size of the weighted draws is too small:\n"
          : of_tours ? "\nCan't be judged:\n"
                     : "\nNot mixed:\n";
  const std::size_t shown = std::min(diagnosis.reasons.size(), k_reasons_shown);
  for (std::size_t i = 0; i < shown; ++i)
    text += fmt::format("  {}\n", diagnosis.reasons[i]);
  if (shown < diagnosis.reasons.size()) {
    text +=
        fmt::format("  and {} more reasons (--json shows all)\n", diagnosis.reasons.size() - shown);
  }
}

Json as_json(const TemperingReport& tempering) {
  return {
      {"round", tempering.round},
      {"rounds", tempering.rounds},
      {"burn_in", tempering.burn_in},
      {"ladders", report::list_of(report::reports_of(tempering.ladders, k_numbered_report_of))}};
}

Json as_json(const WeightsReport& weights) {
  return {
      {"effective_size", weights.effective_size},
      {"log_z", as_json(weights.log_z.log)},
      {"log_p_satisfied", as_json(weights.log_p_satisfied.log)},
      {"chains", report::list_of(report::reports_of(weights.chains, [](const AscentReport& chain) {
         return report_of_draws("", 0, chain);
       }))}};
}

void add_walks_and_transitions(Json& json, const Diagnosis& diagnosis) {
  if (!diagnosis.walks.empty())
    json["walks"] = report::list_of(report::reports_of(diagnosis.walks, k_numbered_report_of));
  if (!diagnosis.transitions.empty())
    json["tempered_transitions"] =
        report::list_of(report::reports_of(diagnosis.transitions, k_numbered_report_of));
}

}  // namespace

std::string for_people(const std::string& path, const Diagnosis& diagnosis) {
  const Round& judged = diagnosis.judged;
  std::string text = fmt::format("{}: {}, {} chain{} of {} scan{}\n", path, diagnosis.world,
                                 count(diagnosis.chains), diagnosis.chains == 1 ? "" : "s",
                                 count(diagnosis.scans), diagnosis.scans == 1 ? "" : "s");
  if (!diagnosis.warning.empty()) text += fmt::format("Warning: {}\n", diagnosis.warning);
  text += fmt::format("\nJudged scans of each chain: {} to {} ({}).\n\n", count(judged.first_scan),
                      count(judged.first_scan + judged.scans - 1), in_words(diagnosis.which));
  if (diagnosis.weights) {
    append_weights(text, diagnosis);
  } else {
    text += report::indented_table(report::reports_of(diagnosis.scalars, k_report_of));
    append_variables(text, diagnosis);
  }
  append_counts(text, diagnosis);
  append_kinds(text, diagnosis);
  append_walks(text, diagnosis.walks);
  append_transitions(text, diagnosis.transitions);
  if (diagnosis.tempering) append_tempering(text, diagnosis);
  append_verdict(text, diagnosis);
  return text;
}

Json as_json(const std::string& path, const Diagnosis& diagnosis) {
  Json variables = Json::array();
  for (const VariableReport& variable : diagnosis.variables) {
    variables.push_back(
        {{"name", variable.name},
         {"entries", variable.entries},
         {"judged", variable.judged},
         {"failing", variable.failing},
         {"listed", report::list_of(report::reports_of(variable.listed, k_report_of))}});
  }
  const std::uint64_t judged = diagnosis.chains * diagnosis.judged.scans;
  Json json{{"archive", path},
            {"world", diagnosis.world},
            {"warning", diagnosis.warning},
            {"mixed", diagnosis.mixed()},
            {"reasons", diagnosis.reasons},
            {"notes", diagnosis.notes},
            {"chains", diagnosis.chains},
            {"scans", diagnosis.scans},
            {"judged",
             {{"what", name_of(diagnosis.which)},
              {"first_scan", diagnosis.judged.first_scan},
              {"scans", diagnosis.judged.scans},
              {"states", diagnosis.states}}},
            {"scalars", report::list_of(report::reports_of(diagnosis.scalars, k_report_of))},
            {"variables", variables},
            {"satisfied_share", share_of(diagnosis.satisfied, diagnosis.chains * diagnosis.scans)},
            {"satisfied_share_judged", share_of(diagnosis.satisfied_judged, judged)},
            {"independent_solutions", diagnosis.solutions},
            {"independent_solutions_at_least", diagnosis.solutions_more},
            {"simulations", diagnosis.simulations},
            {"proposal_kinds", report::list_of(report::reports_of(diagnosis.kinds, k_report_of))}};
  if (diagnosis.tempering) json["tempering"] = as_json(*diagnosis.tempering);
  add_walks_and_transitions(json, diagnosis);
  if (diagnosis.weights) json["weights"] = as_json(*diagnosis.weights);
  return json;
}

}  // namespace sleight::analysis
