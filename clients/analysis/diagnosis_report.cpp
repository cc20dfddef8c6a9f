#include "clients/analysis/diagnosis_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "common/json/value.h"

namespace sleight::analysis {
namespace {

using Json = json::Value;

/// Ladders shown level by level; temperatures shown side by side; reasons shown.
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

/// "12,345"; a number too large for that as "1.2e+20".
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

using Row = std::vector<std::string>;

/// Rows of equal length as columns: the first to the left, the others to the right.
void append_table(std::string& text, const std::vector<Row>& rows, std::string_view indent) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i)
      widths[i] = std::max(widths[i], row[i].size());
  }
  for (const Row& row : rows) {
    std::string line(indent);
    line += fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i < row.size(); ++i)
      line += fmt::format("  {:>{}}", row[i], widths[i]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
}

Row scalar_row(const ScalarReport& report) {
  const Verdict& verdict = report.verdict;
  std::string remark;
  if (!verdict.complaints.empty()) remark = "<- not mixed";
  if (verdict.constant) remark = "never changes";
  const auto note = [&](std::uint64_t times, std::string_view what) {
    if (times == 0) return;
    remark += fmt::format("{}{} {}", remark.empty() ? "" : "; ", count(times), what);
  };
  note(report.not_finite.minus_infinite, "are -inf");
  note(report.not_finite.nan, "don't apply");
  return {report.name,
          number(verdict.mean),
          number(verdict.sd),
          number(verdict.mcse),
          fixed(verdict.r_hat, 3),
          count(verdict.ess_bulk),
          count(verdict.ess_tail),
          remark};
}

/// Remarks stand to the left of their column, so they are put on after the table.
void append_scalars(std::string& text, const std::vector<ScalarReport>& reports) {
  std::vector<Row> rows{{"", "mean", "sd", "MCSE", "R-hat", "bulk ESS", "tail ESS", ""}};
  for (const ScalarReport& report : reports)
    rows.push_back(scalar_row(report));
  std::size_t widest = 0;
  for (const Row& row : rows)
    widest = std::max(widest, row.back().size());
  for (Row& row : rows)
    row.back().resize(widest, ' ');
  append_table(text, rows, "  ");
}

void append_variables(std::string& text, const Diagnosis& diagnosis) {
  if (diagnosis.variables.empty()) return;
  text += fmt::format("\nState variables, by {} archived states of each chain\n",
                      count(diagnosis.states));
  std::vector<ScalarReport> listed;
  std::vector<std::string> rest;
  for (const VariableReport& variable : diagnosis.variables) {
    listed.insert(listed.end(), variable.listed.begin(), variable.listed.end());
    const std::uint64_t shown = variable.listed.size();
    if (shown == variable.judged) continue;
    rest.push_back(fmt::format("{}: the worst {} of {} entries; {} of all have not mixed",
                               variable.name, shown, count(variable.judged),
                               variable.failing == 0 ? "none" : count(variable.failing)));
  }
  append_scalars(text, listed);
  for (const std::string& line : rest)
    text += fmt::format("  {}\n", line);
}

void append_counts(std::string& text, const Diagnosis& diagnosis) {
  const std::uint64_t judged = diagnosis.chains * diagnosis.judged.scans;
  text += "\n";
  append_table(
      text,
      {{"satisfied",
        fmt::format("{} of the judged scans, {} of all{}",
                    percent(share_of(diagnosis.satisfied_judged, judged)),
                    percent(share_of(diagnosis.satisfied, diagnosis.chains * diagnosis.scans)),
                    diagnosis.weights ? ", each counted once whatever its weight" : "")}},
      "  ");
  text += fmt::format("  solutions  {}{} independent: lineages with a satisfied scan\n",
                      count(diagnosis.solutions), diagnosis.solutions_more ? " or more" : "");
  if (std::isnan(diagnosis.simulations)) return;
  text +=
      fmt::format("  simulated  {}: the number of proposals and of draws from the prior{}\n",
                  count(diagnosis.simulations), diagnosis.tempering ? ", at all temperatures" : "");
}

void append_kinds(std::string& text, const Diagnosis& diagnosis) {
  text += fmt::format("\nAcceptance in the judged scans{}\n",
                      diagnosis.tempering ? ", at inverse temperature 1" : "");
  std::vector<Row> rows{{"", "proposed", "accepted", ""}};
  for (const KindReport& kind : diagnosis.kinds) {
    rows.push_back({kind.name, count(kind.proposed), count(kind.accepted),
                    percent(share_of(kind.accepted, kind.proposed))});
  }
  append_table(text, rows, "  ");
}

double least(const std::vector<double>& values) {
  double found = std::numeric_limits<double>::quiet_NaN();
  for (const double value : values) {
    if (!(value >= found)) found = value;
  }
  return found;
}

void append_ladders(std::string& text, const TemperingReport& tempering) {
  text += fmt::format("\nLadders in round {} of {}{}\n", tempering.round, tempering.rounds,
                      tempering.burn_in ? " of the burn-in" : "");
  std::vector<Row> rows{
      {"", "temperatures", "barrier", "least swapped", "round trips", "predicted", "restarts"}};
  for (std::size_t i = 0; i < tempering.ladders.size(); ++i) {
    const LadderReport& ladder = tempering.ladders[i];
    rows.push_back({fmt::format("ladder {}", i), count(ladder.levels.inverse_temperature.size()),
                    fixed(ladder.barrier, 2), percent(least(ladder.levels.swap_acceptance)),
                    count(ladder.round_trips), fixed(ladder.predicted_round_trips, 1),
                    count(ladder.restarts)});
  }
  append_table(text, rows, "  ");
}

void append_levels(std::string& text, const Ladder& ladder, std::size_t index) {
  text += fmt::format("\nLadder {} by inverse temperature, from the prior on\n", index);
  std::vector<Row> rows{{"", "inverse temperature", "swaps with the next", "local barrier"}};
  for (std::size_t level = 0; level < ladder.inverse_temperature.size(); ++level) {
    const bool has_next = level < ladder.swap_acceptance.size();
    rows.push_back({fmt::format("level {}", level), number(ladder.inverse_temperature[level]),
                    has_next ? percent(ladder.swap_acceptance[level]) : "",
                    number(ladder.local_barrier[level])});
  }
  append_table(text, rows, "  ");
}

/// Kinds down, temperatures across: all, or as many as fit, the first and last among them.
void append_acceptance(std::string& text, const Diagnosis& diagnosis, const Ladder& ladder,
                       std::size_t index) {
  const std::size_t levels = ladder.acceptance.size();
  if (levels == 0) return;
  const std::size_t columns = std::min(levels, k_columns_shown);
  text += fmt::format("\nAcceptance on ladder {} by inverse temperature{}\n", index,
                      columns < levels ? fmt::format(", {} of {}", columns, levels) : "");
  std::vector<Row> rows(1 + diagnosis.kinds.size());
  rows[0].emplace_back("");
  for (std::size_t k = 0; k < diagnosis.kinds.size(); ++k)
    rows[k + 1].push_back(diagnosis.kinds[k].name);
  for (std::size_t column = 0; column < columns; ++column) {
    const std::size_t level = columns == 1 ? 0 : column * (levels - 1) / (columns - 1);
    rows[0].push_back(fmt::format("{:.3g}", ladder.inverse_temperature[level]));
    for (std::size_t k = 0; k < diagnosis.kinds.size(); ++k) {
      const std::vector<double>& row = ladder.acceptance[level];
      rows[k + 1].push_back(k < row.size() ? percent(row[k]) : "-");
    }
  }
  append_table(text, rows, "  ");
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
    text += fmt::format("\n  {} more ladders by temperature: --json\n",
                        tempering.ladders.size() - shown);
  }
}

void append_walks(std::string& text, const std::vector<WalkReport>& walks) {
  if (walks.empty()) return;
  text += "\nWalks over temperatures\n";
  std::vector<Row> rows{{"", "temperatures", "round trips", "least visited", "least moved"}};
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const WalkReport& walk = walks[i];
    std::vector<double> moves = walk.acceptance;
    if (!moves.empty()) moves.pop_back();  // the coolest has no next
    double scans = 0;
    for (const double visits : walk.visits)
      scans += visits;
    rows.push_back({fmt::format("chain {}", i), count(walk.inverse_temperature.size()),
                    count(walk.round_trips), percent(least(walk.visits) / scans),
                    percent(least(moves))});
  }
  append_table(text, rows, "  ");
  const std::size_t shown = std::min(walks.size(), k_ladders_shown);
  for (std::size_t i = 0; i < shown; ++i) {
    text += fmt::format("\nWalk of chain {} by inverse temperature, from the prior on\n", i);
    std::vector<Row> levels{{"", "inverse temperature", "scans", "moves to the next and back"}};
    for (std::size_t level = 0; level < walks[i].visits.size(); ++level) {
      const bool has_next = level + 1 < walks[i].visits.size();
      levels.push_back({fmt::format("level {}", level), number(walks[i].inverse_temperature[level]),
                        count(walks[i].visits[level]),
                        has_next ? percent(walks[i].acceptance[level]) : ""});
    }
    append_table(text, levels, "  ");
  }
}

void append_transitions(std::string& text, const std::vector<TransitionReport>& transitions) {
  if (transitions.empty()) return;
  text += "\nTempered transitions\n";
  std::vector<Row> rows{{"", "temperatures down", "accepted"}};
  for (std::size_t i = 0; i < transitions.size(); ++i)
    rows.push_back({fmt::format("chain {}", i), count(transitions[i].levels),
                    percent(transitions[i].acceptance)});
  append_table(text, rows, "  ");
}

std::string with_error(const LogEstimate& estimate) {
  return fmt::format("{} +- {}", fixed(estimate.value, 3), fixed(estimate.error, 3));
}

/// Weighted draws, chain by chain and together.
void append_weights(std::string& text, const Diagnosis& diagnosis) {
  const WeightsReport& weights = *diagnosis.weights;
  text += "Draws are independent and have weights\n";
  std::vector<Row> rows{{"", "draws", "effective size", "steps", "log Z", "log P(satisfied)"}};
  const std::size_t shown = std::min(weights.chains.size(), k_chains_shown);
  for (std::size_t i = 0; i < shown; ++i) {
    const AscentReport& chain = weights.chains[i];
    rows.push_back({fmt::format("chain {}", i), count(diagnosis.scans),
                    fixed(chain.effective_size, 1), count(chain.steps), with_error(chain.log_z),
                    with_error(chain.log_p_satisfied)});
  }
  rows.push_back({"all", count(diagnosis.chains * diagnosis.scans),
                  fixed(weights.effective_size, 1), "", with_error(weights.log_z.log),
                  with_error(weights.log_p_satisfied.log)});
  append_table(text, rows, "  ");
  if (shown < weights.chains.size())
    text += fmt::format("  {} more chains: --json\n", weights.chains.size() - shown);
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
      return "a round, in which neither ladder nor sizes of proposals change";
    case JudgedDraws::all:
      return "all after the burn-in";
    case JudgedDraws::tours:
      return "all, each the last scan of a tour";
    case JudgedDraws::weighted:
      return "all, by their weights";
  }
  return "";
}

void append_verdict(std::string& text, const Diagnosis& diagnosis) {
  for (const std::string& note : diagnosis.notes)
    text += fmt::format("\nNote: {}.\n", note);
  const bool weighted = diagnosis.weights.has_value();
  if (diagnosis.mixed()) {
    text += weighted ? "\nThe draws are worth enough.\n"
                     : "\nNothing here says that the chains have not mixed.\n";
    return;
  }
  const bool of_tours = diagnosis.which == JudgedDraws::tours;
  text += weighted ? "\nNot enough:\n" : of_tours ? "\nCan't be judged:\n" : "\nNot mixed:\n";
  const std::size_t shown = std::min(diagnosis.reasons.size(), k_reasons_shown);
  for (std::size_t i = 0; i < shown; ++i)
    text += fmt::format("  {}\n", diagnosis.reasons[i]);
  if (shown < diagnosis.reasons.size()) {
    text += fmt::format("  and {} more reasons: --json\n", diagnosis.reasons.size() - shown);
  }
}

Json as_json(const ScalarReport& report) {
  const Verdict& verdict = report.verdict;
  return {{"name", report.name},
          {"mean", verdict.mean},
          {"sd", verdict.sd},
          {"mcse_mean", verdict.mcse},
          {"r_hat", verdict.r_hat},
          {"ess_bulk", verdict.ess_bulk},
          {"ess_tail", verdict.ess_tail},
          {"constant", verdict.constant},
          {"minus_infinite", report.not_finite.minus_infinite},
          {"not_applicable", report.not_finite.nan},
          {"complaints", verdict.complaints}};
}

Json as_json(const std::vector<ScalarReport>& reports) {
  Json all = Json::array();
  for (const ScalarReport& report : reports)
    all.push_back(as_json(report));
  return all;
}

Json as_json(const TemperingReport& tempering) {
  Json ladders = Json::array();
  for (const LadderReport& ladder : tempering.ladders) {
    ladders.push_back({{"barrier", ladder.barrier},
                       {"round_trips", ladder.round_trips},
                       {"predicted_round_trips", ladder.predicted_round_trips},
                       {"restarts", ladder.restarts},
                       {"inverse_temperature", ladder.levels.inverse_temperature},
                       {"swap_acceptance", ladder.levels.swap_acceptance},
                       {"local_barrier", ladder.levels.local_barrier},
                       {"acceptance", ladder.levels.acceptance}});
  }
  return {{"round", tempering.round},
          {"rounds", tempering.rounds},
          {"burn_in", tempering.burn_in},
          {"ladders", ladders}};
}

Json as_json(const LogEstimate& estimate) {
  return {{"value", estimate.value}, {"error", estimate.error}};
}

Json as_json(const WeightsReport& weights) {
  Json chains = Json::array();
  for (const AscentReport& chain : weights.chains) {
    chains.push_back({{"effective_size", chain.effective_size},
                      {"steps", chain.steps},
                      {"log_z", as_json(chain.log_z)},
                      {"log_p_satisfied", as_json(chain.log_p_satisfied)}});
  }
  return {{"effective_size", weights.effective_size},
          {"log_z", as_json(weights.log_z.log)},
          {"log_p_satisfied", as_json(weights.log_p_satisfied.log)},
          {"chains", chains}};
}

void add_walks_and_transitions(Json& json, const Diagnosis& diagnosis) {
  for (const WalkReport& walk : diagnosis.walks) {
    json["walks"].push_back({{"round_trips", walk.round_trips},
                             {"inverse_temperature", walk.inverse_temperature},
                             {"visits", walk.visits},
                             {"acceptance", walk.acceptance}});
  }
  for (const TransitionReport& chain : diagnosis.transitions) {
    json["tempered_transitions"].push_back(
        {{"acceptance", chain.acceptance}, {"temperatures", chain.levels}});
  }
}

}  // namespace

std::string for_people(const std::string& path, const Diagnosis& diagnosis) {
  const Round& judged = diagnosis.judged;
  std::string text = fmt::format("{}: {}, {} chain{} of {} scan{}\n", path, diagnosis.world,
                                 count(diagnosis.chains), diagnosis.chains == 1 ? "" : "s",
                                 count(diagnosis.scans), diagnosis.scans == 1 ? "" : "s");
  if (!diagnosis.warning.empty()) text += fmt::format("Warning: {}\n", diagnosis.warning);
  text +=
      fmt::format("\nJudged are scans {} to {} of each chain: {}.\n\n", count(judged.first_scan),
                  count(judged.first_scan + judged.scans - 1), in_words(diagnosis.which));
  if (diagnosis.weights) {
    append_weights(text, diagnosis);
  } else {
    append_scalars(text, diagnosis.scalars);
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
    variables.push_back({{"name", variable.name},
                         {"entries", variable.entries},
                         {"judged", variable.judged},
                         {"failing", variable.failing},
                         {"listed", as_json(variable.listed)}});
  }
  Json kinds = Json::array();
  for (const KindReport& kind : diagnosis.kinds) {
    kinds.push_back(
        {{"name", kind.name}, {"proposed", kind.proposed}, {"accepted", kind.accepted}});
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
            {"scalars", as_json(diagnosis.scalars)},
            {"variables", variables},
            {"satisfied_share", share_of(diagnosis.satisfied, diagnosis.chains * diagnosis.scans)},
            {"satisfied_share_judged", share_of(diagnosis.satisfied_judged, judged)},
            {"independent_solutions", diagnosis.solutions},
            {"independent_solutions_at_least", diagnosis.solutions_more},
            {"simulations", diagnosis.simulations},
            {"proposal_kinds", kinds}};
  if (diagnosis.tempering) json["tempering"] = as_json(*diagnosis.tempering);
  add_walks_and_transitions(json, diagnosis);
  if (diagnosis.weights) json["weights"] = as_json(*diagnosis.weights);
  return json;
}

}  // namespace sleight::analysis
